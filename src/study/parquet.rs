//! The results as Parquet: one column after the other, row group by row group.

use std::io::Write;
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{Type, TypePtr};

use super::columns::{Column, Kind};

/// Rows of a group: what is held before it is written.
const GROUP: usize = 8192;

/// Writes rows of cells as typed columns; a blank cell is null.
pub struct Table<W: Write + Send> {
    columns: Vec<Column>,
    writer: SerializedFileWriter<W>,
    cells: Vec<Vec<String>>,
}

impl<W: Write + Send> Table<W> {
    /// Begins a file with these columns.
    pub fn new(to: W, columns: Vec<Column>) -> Result<Table<W>, ParquetError> {
        let fields: Result<Vec<TypePtr>, ParquetError> = columns.iter().map(field).collect();
        let schema = Arc::new(Type::group_type_builder("study").with_fields(fields?).build()?);
        let properties = WriterProperties::builder()
            .set_created_by(format!("gearwise {}", env!("CARGO_PKG_VERSION")))
            .set_statistics_enabled(EnabledStatistics::Chunk)
            .set_offset_index_disabled(true)
            .build();
        let writer = SerializedFileWriter::new(to, schema, Arc::new(properties))?;
        let cells = vec![Vec::new(); columns.len()];
        Ok(Table { columns, writer, cells })
    }

    /// Adds a row.
    pub fn row<'c>(&mut self, row: impl IntoIterator<Item = &'c str>) -> Result<(), ParquetError> {
        for (column, cell) in self.cells.iter_mut().zip(row) {
            column.push(cell.to_string());
        }
        if self.cells[0].len() >= GROUP { self.group() } else { Ok(()) }
    }

    fn group(&mut self) -> Result<(), ParquetError> {
        if self.cells[0].is_empty() {
            return Ok(());
        }
        let mut group = self.writer.next_row_group()?;
        for (column, cells) in self.columns.iter().zip(&mut self.cells) {
            let mut writer = group.next_column()?.ok_or_else(|| ParquetError::General("a column too many".into()))?;
            // One where the cell has a value, zero where it is null.
            let defined: Vec<i16> = cells.iter().map(|c| i16::from(!c.is_empty())).collect();
            let texts = || cells.iter().filter(|c| !c.is_empty());
            let wrong = |what: &str| ParquetError::General(format!("a cell of `{}` is not {what}", column.name));
            match column.kind {
                Kind::Integer => {
                    let values: Option<Vec<i64>> = texts().map(|c| c.parse().ok()).collect();
                    let values = values.ok_or_else(|| wrong("a whole number"))?;
                    writer.typed::<Int64Type>().write_batch(&values, Some(&defined), None)?;
                }
                Kind::Number => {
                    let values: Option<Vec<f64>> = texts().map(|c| c.parse().ok()).collect();
                    let values = values.ok_or_else(|| wrong("a number"))?;
                    writer.typed::<DoubleType>().write_batch(&values, Some(&defined), None)?;
                }
                Kind::Text => {
                    let values: Vec<ByteArray> = texts().map(|c| ByteArray::from(c.as_str())).collect();
                    writer.typed::<ByteArrayType>().write_batch(&values, Some(&defined), None)?;
                }
            }
            writer.close()?;
            cells.clear();
        }
        group.close()?;
        Ok(())
    }

    /// Writes what is left and the footer.
    pub fn finish(mut self) -> Result<W, ParquetError> {
        self.group()?;
        self.writer.into_inner()
    }
}

fn field(column: &Column) -> Result<TypePtr, ParquetError> {
    let (physical, logical) = match column.kind {
        Kind::Integer => (Physical::INT64, None),
        Kind::Number => (Physical::DOUBLE, None),
        Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
    };
    let field = Type::primitive_type_builder(&column.name, physical).with_repetition(Repetition::OPTIONAL);
    Ok(Arc::new(field.with_logical_type(logical).build()?))
}
