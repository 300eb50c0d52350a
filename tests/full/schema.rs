//! docs/schema.json is what the program makes; `INSTA_UPDATE=always` writes it.

use std::fs;

use crate::common::repository;

#[test]
fn the_published_schema_is_that_of_the_program() {
    let path = repository("docs/schema.json");
    let made = gearwise::report::json_text(&gearwise::pages::schema::schema());
    if std::env::var("INSTA_UPDATE").is_ok_and(|v| v == "always") {
        fs::write(path, made).unwrap();
    } else {
        assert!(
            fs::read_to_string(path).unwrap() == made,
            "INSTA_UPDATE=always cargo test --features full --test full schema"
        );
    }
}
