//! The cells of a table in one text: a row takes some bytes beside its characters, not some hundred.

/// Rows of cells. The text is at most [`TABLE_BYTES`](crate::input::limits::TABLE_BYTES), so 32 bits count it.
#[derive(Debug, Default)]
pub struct Cells {
    text: String,
    /// End of each cell.
    ends: Vec<u32>,
    /// Cells before each row, and in it.
    rows: Vec<(u32, u32)>,
}

impl Cells {
    /// Add a row.
    pub fn push(&mut self, record: &csv::StringRecord) {
        self.rows.push((self.ends.len() as u32, record.len() as u32));
        for cell in record {
            self.text.push_str(cell);
            self.ends.push(self.text.len() as u32);
        }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Number of cells of a row.
    pub fn width(&self, row: usize) -> usize {
        self.rows[row].1 as usize
    }

    /// Number of cells of each row.
    pub fn widths(&self) -> impl Iterator<Item = usize> {
        self.rows.iter().map(|(_, width)| *width as usize)
    }

    /// A cell, where the row has so many.
    pub fn get(&self, row: usize, column: usize) -> Option<&str> {
        let (before, width) = self.rows[row];
        if column >= width as usize {
            return None;
        }
        let at = before as usize + column;
        let start = at.checked_sub(1).map_or(0, |before| self.ends[before] as usize);
        Some(&self.text[start..self.ends[at] as usize])
    }

    /// The cells of a row.
    pub fn row(&self, row: usize) -> impl Iterator<Item = &str> + Clone {
        (0..self.width(row)).filter_map(move |column| self.get(row, column))
    }

    /// Take the first row away.
    pub fn remove_first(&mut self) {
        self.rows.remove(0);
    }

    /// Take away the rows of any other number of cells.
    pub fn keep_of_width(&mut self, width: usize) {
        self.rows.retain(|(_, own)| *own as usize == width);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_stay_at_their_rows() {
        let mut cells = Cells::default();
        for row in [&["a", "", "ü"][..], &["1"], &["", "x", ""]] {
            cells.push(&csv::StringRecord::from(row));
        }
        assert_eq!(cells.row(0).collect::<Vec<_>>(), ["a", "", "ü"]);
        assert_eq!((cells.len(), cells.get(1, 0), cells.get(1, 1)), (3, Some("1"), None));
        cells.remove_first();
        cells.keep_of_width(3);
        assert_eq!((cells.len(), cells.row(0).collect::<Vec<_>>()), (1, vec!["", "x", ""]));
    }
}
