//! A catalogue against a second source of the same rows.

use std::fs;

use crate::common::repository;
use crate::common::run::{gearwise_in, json, stderr, stdout};

const HEADER: &str =
    "id,kind,ratio,stages,efficiency,mass [g],peak_torque [N*m],backlash [arcmin],source,source_kind\n";

#[test]
fn what_two_sources_do_not_agree_on_is_said_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let ours = format!(
        "{HEADER}a,planetary,9,2,0.9,150,10,,a sheet,datasheet\nb,planetary,16,2,0.9,300,20,5,a sheet,datasheet\n\
         mine,planetary,4,1,0.95,100,5,,a sheet,datasheet\n"
    );
    write("ours.csv", &ours);
    // Half a per cent is rounding; 2 % is another number.
    let second = |id: &str, mass: f64| {
        format!(
            "{HEADER}{id},planetary,9,2,0.9,{mass},10,,a page,secondary\nb,planetary,16,2,,300,20.09,,a page,secondary\n\
             theirs,planetary,5,1,0.95,100,5,,a page,secondary\n"
        )
    };
    write("second.csv", &second("a", 153.0));
    let run =
        |arguments: &[&str]| gearwise_in(folder.path(), &[&["audit", "ours.csv", "--against"], arguments].concat());
    let output = run(&["second.csv"]);
    let text = stdout(&output);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(text.contains("mass: 150 g here, 153 g there (+2 %)") && !text.contains("20.09"), "{text}");
    assert!(text.contains("backlash: 5 arcmin here") && text.contains("efficiency: 0.9 here"), "{text}");
    assert!(
        text.contains(
            "2 rows in both, 1 here alone, 1 there alone; 7 numbers compared, 1 more than 1 % apart, 2 in one of them alone"
        ),
        "{text}"
    );
    let answer = json(&run(&["second.csv", "--json"]));
    assert_eq!((answer["both"].as_u64(), answer["apart"][0]["id"].as_str()), (Some(2), Some("a")));
    assert_eq!(answer["apart"][0]["changes"].as_array().unwrap().len(), 1);
    // Nothing is apart: status 0, and what one of them lacks is said still.
    write("second.csv", &second("a", 150.5));
    let output = run(&["second.csv"]);
    assert_eq!(output.status.code(), Some(0), "{}", stdout(&output));
    assert!(
        stdout(&output).contains("7 numbers compared, 0 more than 1 % apart, 2 in one of them alone"),
        "{}",
        stdout(&output)
    );
    // Another name for the same part.
    write("second.csv", &second("part-9", 153.0));
    write("ids.csv", "second,own\npart-9,a\n");
    let output = run(&["second.csv", "--map", "ids.csv"]);
    assert!(stdout(&output).contains("gear a") && stdout(&output).contains("2 rows in both"), "{}", stdout(&output));
    for (ids, said) in [
        ("second,own\nnobody,a\n", "the second source has no row `nobody`"),
        ("second,mine\npart-9,a\n", "there is no column `own`"),
        ("second,own\npart-9,a\npart-9,b\n", "`part-9` has two of ours"),
        ("second,own\npart-9,zzz\n", "the catalogue has no row `zzz`"),
    ] {
        write("ids.csv", ids);
        let output = run(&["second.csv", "--map", "ids.csv"]);
        assert!(output.status.code() == Some(2) && stderr(&output).contains(said), "{said}: {}", stderr(&output));
    }
    // Two rows of theirs for one of ours: one of them would be dropped without a word.
    write(
        "second.csv",
        &[second("part-9", 153.0), second("part-8", 153.0).lines().nth(1).unwrap().to_string()].concat(),
    );
    write("ids.csv", "second,own\npart-9,a\npart-8,a\n");
    let output = run(&["second.csv", "--map", "ids.csv"]);
    assert!(output.status.code() == Some(2) && stderr(&output).contains("two rows of the second source are `a`"));
    // The built-in catalogue has points of families, which are rows as well.
    let output = gearwise_in(folder.path(), &["audit", "--against", "ours.csv"]);
    // Where nothing is compared, nothing is agreed.
    assert_eq!(output.status.code(), Some(1));
    assert!(stdout(&output).contains("Nothing is compared: no id is in both."), "{}", stdout(&output));
    assert!(
        stdout(&output).contains("\n0 rows in both, ") || stdout(&output).starts_with("0 rows in both, "),
        "{}",
        stdout(&output)
    );
    let output = run(&["nowhere.csv"]);
    assert!(output.status.code() == Some(2) && stderr(&output).contains("nowhere.csv"), "{}", stderr(&output));
}

/// Amperes that mean something else are not compared: nothing is called apart that is not.
#[test]
fn numbers_of_other_conventions_are_not_called_apart() {
    let folder = tempfile::tempdir().unwrap();
    let header =
        "id,commutation,terminals,current,resistance [ohm],torque_constant [N*m/A],mass [g],source,source_kind\n";
    let write = |name: &str, row: &str| fs::write(folder.path().join(name), format!("{header}{row}\n")).unwrap();
    write("ours.csv", "m,brushless,line_to_line,rms,0.5,0.1,200,a sheet,datasheet");
    write("second.csv", "m,brushless,line_to_line,phase_amplitude,0.5,0.0707,200,a page,secondary");
    let output = gearwise_in(folder.path(), &["audit", "ours.csv", "--against", "second.csv"]);
    let text = stdout(&output);
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(text.contains("are not compared: m") && !text.contains("torque_constant"), "{text}");
}

/// Every row that is shipped says where it is from; where a number was derived, its note says how.
#[test]
fn every_shipped_row_has_its_source() {
    let mut rows = 0;
    for kind in ["motors", "gears", "modules"] {
        for file in fs::read_dir(repository("catalogs").join(kind)).unwrap() {
            let path = file.unwrap().path();
            let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(&path).unwrap();
            let header = reader.headers().unwrap().clone();
            let at = |name: &str| header.iter().position(|h| h.split(" [").next() == Some(name));
            let [id, source, date, of] = ["id", "source", "source_date", "source_kind"].map(|name| at(name).unwrap());
            for record in reader.records() {
                let record = record.unwrap();
                let name = format!("{}: {}", path.display(), &record[id]);
                assert!(record[source].len() > 12, "{name}: {}", &record[source]);
                assert!(!record[of].is_empty() && record[date].starts_with("20"), "{name}: {}", &record[date]);
                if &record[of] == "derived" {
                    assert!(at("note").is_some_and(|n| !record[n].is_empty()), "{name}");
                }
                rows += 1;
            }
        }
    }
    assert!(rows > 600, "{rows}");
}
