//! Parquet files and NumPy archives: what they hold, and what is wrong with them.

use gearwise::measured::Channel;
use parquet::data_type::{BoolType, ByteArrayType, DoubleType, FloatType, Int32Type, Int64Type};

use super::write::{self, Packed, npy, numbers};
use super::{BENCH, few, outcome, refused};

fn good(bench: &str, name: &str, log: &[u8]) -> gearwise::measured::Bench {
    outcome(bench, name, log).unwrap_or_else(|e| panic!("{e}"))
}

fn owned(columns: Vec<(&str, Vec<f64>)>) -> Vec<(String, Vec<f64>)> {
    columns.into_iter().map(|(name, values)| (name.to_string(), values)).collect()
}

/// The few rows as files of an archive, one of them another.
fn files(name: &str, content: Vec<u8>) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> =
        few().into_iter().filter(|(n, _)| *n != name).map(|(n, v)| (format!("{n}.npy"), numbers(&v))).collect();
    files.push((format!("{name}.npy"), content));
    files
}

fn bytes<const N: usize>(values: impl IntoIterator<Item = [u8; N]>) -> Vec<u8> {
    values.into_iter().flatten().collect()
}

#[test]
fn every_packing_and_every_kind_of_number_is_read() {
    let columns = owned(few());
    for packed in [Packed::Not, Packed::Snappy, Packed::Gzip, Packed::Lz4] {
        let bench = good(BENCH, "log.parquet", &write::parquet(&columns, packed));
        assert_eq!(bench.logs[0].channel(Channel::MotorVelocity), Some(&few()[2].1[..]), "{packed:?}");
        assert_eq!(bench.logs[0].time, few()[0].1);
    }
    let tau = |descr: &str, data: &[u8]| {
        let log = write::zip(&files("tau", npy(descr, false, "(4,)", data)), false);
        good(BENCH, "log.npz", &log).logs[0].channel(Channel::Torque).unwrap().to_vec()
    };
    let expected = [1.0, -2.0, 3.0, 4.0];
    assert_eq!(tau("'<f8'", &bytes(expected.map(f64::to_le_bytes))), expected);
    assert_eq!(tau("'>f8'", &bytes(expected.map(f64::to_be_bytes))), expected);
    assert_eq!(tau("'<f4'", &bytes(expected.map(|x| (x as f32).to_le_bytes()))), expected);
    assert_eq!(tau("'<f2'", &bytes([0x3c00_u16, 0xc000, 0x4200, 0x4400].map(u16::to_le_bytes))), expected);
    assert_eq!(tau("'<i8'", &bytes(expected.map(|x| (x as i64).to_le_bytes()))), expected);
    assert_eq!(tau("'>i2'", &bytes(expected.map(|x| (x as i16).to_be_bytes()))), expected);
    assert_eq!(tau("'|i1'", &bytes(expected.map(|x| (x as i8).to_le_bytes()))), expected);
    assert_eq!(tau("'<u4'", &bytes([1_u32, 2, 3, u32::MAX].map(u32::to_le_bytes)))[3], f64::from(u32::MAX));
}

#[test]
fn integers_floats_and_texts_of_a_parquet_file() {
    let schema = "message log { required double t; required int32 i; required float w; optional int64 tau; \
                  required binary run (UTF8); required boolean ok; required int32 n (UINT_32); }";
    let log = write::typed(schema, |at, column| {
        match at {
            0 => column.typed::<DoubleType>().write_batch(&[0.0, 1.0, 2.0, 0.0, 1.0, 2.0], None, None),
            1 => column.typed::<Int32Type>().write_batch(&[1, -2, 3, 4, 5, 6], None, None),
            2 => column.typed::<FloatType>().write_batch(&[0.5, 1.5, 2.5, 1.0, 2.0, 3.0], None, None),
            3 => column.typed::<Int64Type>().write_batch(&[7, 8, 9, 10, 11], Some(&[1, 0, 1, 1, 1, 1]), None),
            4 => {
                let texts = ["a", "a", "a", "b", "b", "b"].map(|t| t.into());
                column.typed::<ByteArrayType>().write_batch(&texts, None, None)
            }
            5 => column.typed::<BoolType>().write_batch(&[true, true, true, false, false, false], None, None),
            _ => column.typed::<Int32Type>().write_batch(&[-1, 1, 2, 3, 4, 5], None, None),
        }
        .unwrap();
    });
    for (select, current) in [
        ("{ column = \"run\", equals = \"a\" }", [1.0, -2.0, 3.0]),
        ("{ column = \"ok\", equals = \"false\" }", [4.0, 5.0, 6.0]),
        ("{ column = \"n\", min = 3, max = 5 }", [4.0, 5.0, 6.0]),
    ] {
        let bench = BENCH.replace("convention = \"phase_amplitude\"", "convention = \"q_axis\"")
            + &format!("select = {select}\n");
        let bench = good(&bench, "log.parquet", &log);
        assert_eq!(bench.logs[0].channel(Channel::Current), Some(&current[..]), "{select}");
    }
    let first = good(&format!("{BENCH}select = {{ column = \"run\", equals = \"a\" }}"), "log.parquet", &log);
    let torque = first.logs[0].channel(Channel::Torque).unwrap();
    assert!(torque[1].is_nan() && torque[0] == 7.0 && torque[2] == 8.0);
    assert_eq!(first.logs[0].remarks, ["1 of 3 cells of `torque` are missing"]);
    // Both uses of one row.
    let other = "[[log]]\nfile = \"log.csv\"\nuse = \"held_out\"\nselect = { column = \"n\", max = 2 }";
    let both = format!("{BENCH}select = {{ column = \"run\", equals = \"a\" }}\n{other}");
    refused(&both, "log.parquet", &log, &["2 rows of", "are both to fit and held out"]);
    refused(
        &format!("{BENCH}select = {{ column = \"run\", equals = \"c\" }}"),
        "log.parquet",
        &log,
        &["no row of", "values of `run`: a, b"],
    );
    refused(
        &BENCH.replace("\"w\"", "\"ok\""),
        "log.parquet",
        &log,
        &["column `ok`: it holds texts, not numbers: `true`", "log.parquet"],
    );
    refused(BENCH, "log.parquet", &log, &["row 4: time goes backwards here, from 2 s to 0 s", "log.parquet"]);
}

#[test]
fn a_column_of_two_dimensions_is_named_as_numpy_names_it() {
    let bench = BENCH.replace("\"tau\"", "\"tau[:,1]\"");
    for fortran in [false, true] {
        let order =
            if fortran { [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0] } else { [1.0, 5.0, 2.0, 6.0, 3.0, 7.0, 4.0, 8.0] };
        let array = npy("'<f8'", fortran, "(4, 2)", &bytes(order.map(f64::to_le_bytes)));
        let log = write::zip(&files("tau", array), true);
        let read = good(&bench, "log.npz", &log);
        assert_eq!(read.logs[0].channel(Channel::Torque), Some(&[5.0, 6.0, 7.0, 8.0][..]), "{fortran}");
        refused(
            BENCH,
            "log.npz",
            &log,
            &["column `tau`: it has two dimensions, 4 by 2", "\"tau[:,0]\" to \"tau[:,1]\"", "log.npz"],
        );
        refused(
            &BENCH.replace("\"tau\"", "\"tau[:,2]\""),
            "log.npz",
            &log,
            &["there is no column `tau[:,2]`", "did you mean `tau[:,"],
        );
    }
    refused(&bench, "log.npz", &write::npz(&owned(few()), false), &["there is no column `tau[:,1]`"]);
}

#[test]
fn what_is_missing_is_counted_as_in_csv() {
    let mut columns = few();
    columns[3].1[1] = f64::NAN;
    columns[1].1[2] = f64::INFINITY;
    for (name, log) in [
        ("log.parquet", write::parquet(&owned(columns.clone()), Packed::Not)),
        ("log.npz", write::npz(&owned(columns), false)),
    ] {
        let bench = good(BENCH, name, &log);
        let remarks = ["1 of 4 cells of `current` are missing", "1 of 4 cells of `torque` are missing"];
        assert_eq!(bench.logs[0].remarks, remarks, "{name}");
    }
    // Nothing is said where nothing is missing.
    assert!(good(BENCH, "log.npz", &write::npz(&owned(few()), false)).logs[0].remarks.is_empty());
}

#[test]
fn arrays_that_are_no_columns_are_refused_by_their_names() {
    let bad = |descr: &str, shape: &str, data: &[u8], parts: &[&str]| {
        refused(BENCH, "log.npz", &write::zip(&files("tau", npy(descr, false, shape, data)), false), parts);
    };
    let data = [0; 64];
    bad("'<c16'", "(4,)", &data, &["column `tau`: it holds complex numbers (<c16)", "log.npz"]);
    bad("'|O'", "(4,)", &data, &["column `tau`: it holds Python objects"]);
    bad("'<M8[ns]'", "(4,)", &data[..32], &["column `tau`: it holds dates"]);
    bad("[('a', '<f8'), ('b', '<f8')]", "(4,)", &data, &["column `tau`: it holds records of several fields"]);
    bad("'<U4'", "(4,)", &data, &["column `tau`: it holds texts, not numbers"]);
    bad("'|b1'", "(4,)", &data[..4], &["column `tau`: it holds texts, not numbers: `false`"]);
    bad("'<f8'", "()", &data[..8], &["column `tau`: it is a single value"]);
    bad("'<f8'", "(2, 2, 2)", &data, &["column `tau`: it has 3 dimensions"]);
    bad("'<f8'", "(3,)", &data[..24], &["column `tau`: it has 3 values, `t` has 4"]);
    bad("'<f8'", "(8,)", &data[..24], &["column `tau`: it has 8 values"]);
    bad("'<f8'", "(3,)", &data[..32], &["column `tau`: it has 3 values"]);
    bad("'<f8'", "(99999999999999999999,)", &data, &["column `tau`: its head does not say its shape"]);
    bad("'<f8'", "(9999999999999999,)", &data, &["column `tau`: its head gives a size that no file has"]);
    bad("'<f8'", "(400000000,)", &data, &["column `tau`: it has 400000000 values"]);
    // What no log asks for may be anything.
    let mut others = files("tau", numbers(&[1.0; 4]));
    others.push(("notes.npy".into(), npy("'|O'", false, "()", b"pickled")));
    others.push(("broken.npy".into(), b"nothing".to_vec()));
    others.push(("readme.txt".into(), b"text".to_vec()));
    good(BENCH, "log.npz", &write::zip(&others, false));
    // Nothing to fit.
    refused(
        BENCH,
        "log.npz",
        &write::npz(&owned(few().into_iter().map(|(n, _)| (n, Vec::new())).collect()), false),
        &["the file has no rows"],
    );
    refused(
        &BENCH.replace("\"w\"", "\"omega\""),
        "log.npz",
        &write::npz(&owned(few()), false),
        &["there is no column `omega`", "its columns: t, i, w, tau"],
    );
    refused(
        &BENCH.replace("\"tau\"", "\"taus\""),
        "log.parquet",
        &write::parquet(&owned(few()), Packed::Not),
        &["there is no column `taus`", "did you mean `tau`?"],
    );
}

#[test]
fn columns_of_a_parquet_file_that_are_no_numbers_are_refused_by_their_names() {
    let bad = |kind: &str, parts: &[&str]| {
        let schema = format!("message log {{ required double t; required double i; required double w; {kind}; }}");
        let log = write::typed(&schema, |at, column| {
            let three = [0.0, 1.0, 2.0];
            if at < 3 {
                column.typed::<DoubleType>().write_batch(&three, None, None).unwrap();
            } else if kind.contains("int64") {
                column.typed::<Int64Type>().write_batch(&[0, 1, 2], None, None).unwrap();
            } else if kind.contains("repeated") {
                column.typed::<DoubleType>().write_batch(&three, Some(&[1; 3]), Some(&[0; 3])).unwrap();
            } else {
                column.typed::<ByteArrayType>().write_batch(&["1".into(), "x".into(), "2".into()], None, None).unwrap();
            }
        });
        refused(BENCH, "log.parquet", &log, parts);
    };
    bad(
        "required int64 tau (TIMESTAMP_MICROS)",
        &["column `tau`: it holds dates, not numbers", "total_seconds()", "log.parquet"],
    );
    bad("required int64 tau (DECIMAL(10, 2))", &["column `tau`: it holds decimals"]);
    bad("repeated double tau", &["column `tau`: its cells are lists"]);
    bad("required binary tau (UTF8)", &["column `tau`: it holds texts, not numbers: `1`"]);
}

#[test]
fn a_file_that_is_not_what_its_name_says_is_refused() {
    let parquet = write::parquet(&owned(few()), Packed::Snappy);
    let npz = write::npz(&owned(few()), true);
    let text = b"t,i,w,tau\n0,1,1,1\n";
    for (name, log, parts) in [
        ("log.npz", &text[..], ["this is not a NumPy archive", "is read as CSV"]),
        ("log.parquet", &text[..], ["this is not a Parquet file", "cut off, or text"]),
        ("log.npz", &parquet[..], ["this is not a NumPy archive", "but a Parquet file"]),
        ("log.parquet", &npz[..], ["this is not a Parquet file", "but a NumPy archive"]),
        ("log.csv", &parquet[..], ["this is a Parquet file, not a CSV file", "has to end in .parquet"]),
        ("log.csv", &npz[..], ["this is a ZIP archive, not a CSV file", "ends in .npz"]),
        ("log.npz", b"", ["the file is empty", "log.npz"]),
        ("log.npz", b"PK", ["the NumPy archive cannot be read", "cut off"]),
        ("log.parquet", b"PAR1", ["the Parquet file cannot be read", "cut off"]),
        ("log.npy", b"\x93NUMPY\x01\x00", ["one NumPy array (.npy)", "np.savez"]),
        ("log.h5", b"\x89HDF\r\n\x1a\n", ["an HDF5 file", "np.savez"]),
        ("log.mat", b"MATLAB 5.0 MAT-file, Platform", ["a MATLAB file", "parquetwrite"]),
        ("log.feather", b"ARROW1\0\0", ["a Feather (Arrow) file", "to_parquet"]),
        ("log.csv.gz", b"\x1f\x8b\x08\0", ["a gzip archive", "gunzip"]),
    ] {
        refused(BENCH, name, log, &parts);
    }
    // A CSV file may begin with these letters.
    let csv = b"PK,t,i,w,tau\n1,0,1,1,1\n1,1,1,1,1\n1,2,1,2,1\n";
    good(BENCH, "log.csv", csv);
    good(BENCH, "PAR1.txt", &csv.map(|b| b)[..]);
}

/// A page that needs a dictionary and has none makes the library panic.
#[test]
fn a_parquet_file_at_which_the_library_panics_is_refused() {
    let found = include_bytes!("../../../fuzz/found/parquet/page-without-its-dictionary");
    refused(
        BENCH,
        "log.parquet",
        &found[1..],
        &["it cannot be read", "its pages contradict one another", "cut off or damaged"],
    );
}

/// Wherever a file is cut off, and whichever byte is another: an error with its file, or the same values.
#[test]
fn a_damaged_file_is_refused_or_read_as_it_was() {
    let whole = good(BENCH, "log.npz", &write::npz(&owned(few()), true)).logs[0].channels.clone();
    for (name, log) in [
        ("log.parquet", write::parquet(&owned(few()), Packed::Snappy)),
        ("log.npz", write::npz(&owned(few()), true)),
        ("log.npz", write::npz(&owned(few()), false)),
    ] {
        for cut in (0..log.len()).step_by(7) {
            refused(BENCH, name, &log[..cut], &[name]);
        }
        for at in (0..log.len()).step_by(3) {
            let mut changed = log.clone();
            changed[at] ^= 0x55;
            match outcome(BENCH, name, &changed) {
                Err(report) => assert!(report.contains("log.") && report.len() < 10_000, "{report}"),
                // Parquet as it is mostly written has no sum of its values.
                Ok(bench) if name == "log.npz" => assert_eq!(bench.logs[0].channels, whole, "byte {at}"),
                Ok(_) => {}
            }
        }
    }
}

#[test]
fn a_ratio_that_no_gear_has_is_marked_in_the_bench() {
    let log = write::npz(&owned(few()), false);
    for (ratio, is_read) in [("1e4", true), ("10001", false), ("1e9", false)] {
        let bench = BENCH.replace("ratio = 9", &format!("ratio = {ratio}"));
        let column = bench.lines().next().unwrap().find(ratio).unwrap() + 1;
        match outcome(&bench, "log.npz", &log) {
            Ok(_) => assert!(is_read, "{ratio}"),
            // The line with the catalogue stands before it.
            Err(report) => assert!(!is_read && report.contains(&format!("bench.toml:2:{column}")), "{report}"),
        }
    }
}

#[test]
fn texts_of_a_parquet_file_count_by_their_memory() {
    // One text of 100 kB, which the file holds once, in each of 2000 rows.
    let schema = "message log { required double t; required binary i (UTF8); required double w; required double tau; }";
    let text = parquet::data_type::ByteArray::from("1".repeat(100_000).into_bytes());
    let numbers: Vec<f64> = (0..2000).map(f64::from).collect();
    let log = write::typed(schema, |at, column| {
        match at {
            1 => column.typed::<ByteArrayType>().write_batch(&vec![text.clone(); 2000], None, None),
            _ => column.typed::<DoubleType>().write_batch(&numbers, None, None),
        }
        .unwrap();
    });
    assert!(log.len() < 1 << 20, "{}", log.len());
    refused(BENCH, "log.parquet", &log, &["column `i`"]);
}
