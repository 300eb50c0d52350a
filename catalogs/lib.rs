#![doc = include_str!("README.md")]

/// Name and text of each file, sorted by name.
pub const FILES: &[(&str, &str)] = &[
    ("catalogs/alternatives/modules.csv", include_str!("alternatives/modules.csv")),
    ("catalogs/gear_families/compact-u8-cpg.toml", include_str!("gear_families/compact-u8-cpg.toml")),
    ("catalogs/gear_families/compact-u8-dspg.toml", include_str!("gear_families/compact-u8-dspg.toml")),
    ("catalogs/gear_families/compact-u8-sspg.toml", include_str!("gear_families/compact-u8-sspg.toml")),
    ("catalogs/gears/apex.csv", include_str!("gears/apex.csv")),
    ("catalogs/gears/beckhoff.csv", include_str!("gears/beckhoff.csv")),
    ("catalogs/gears/belt.csv", include_str!("gears/belt.csv")),
    ("catalogs/gears/cycloidal.csv", include_str!("gears/cycloidal.csv")),
    ("catalogs/gears/faulhaber.csv", include_str!("gears/faulhaber.csv")),
    ("catalogs/gears/harmonic-drive.csv", include_str!("gears/harmonic-drive.csv")),
    ("catalogs/gears/maxon.csv", include_str!("gears/maxon.csv")),
    ("catalogs/gears/qdd.csv", include_str!("gears/qdd.csv")),
    ("catalogs/gears/zd.csv", include_str!("gears/zd.csv")),
    ("catalogs/modules/bxi.csv", include_str!("modules/bxi.csv")),
    ("catalogs/modules/cubemars.csv", include_str!("modules/cubemars.csv")),
    ("catalogs/modules/damiao.csv", include_str!("modules/damiao.csv")),
    ("catalogs/modules/harmonic-drive.csv", include_str!("modules/harmonic-drive.csv")),
    ("catalogs/modules/mit.csv", include_str!("modules/mit.csv")),
    ("catalogs/modules/myactuator.csv", include_str!("modules/myactuator.csv")),
    ("catalogs/modules/robotis.csv", include_str!("modules/robotis.csv")),
    ("catalogs/modules/robstride.csv", include_str!("modules/robstride.csv")),
    ("catalogs/modules/unitree.csv", include_str!("modules/unitree.csv")),
    ("catalogs/motors/allied-motion.csv", include_str!("motors/allied-motion.csv")),
    ("catalogs/motors/faulhaber.csv", include_str!("motors/faulhaber.csv")),
    ("catalogs/motors/kollmorgen.csv", include_str!("motors/kollmorgen.csv")),
    ("catalogs/motors/maxon.csv", include_str!("motors/maxon.csv")),
    ("catalogs/motors/others.csv", include_str!("motors/others.csv")),
    ("catalogs/motors/t-motor.csv", include_str!("motors/t-motor.csv")),
    ("catalogs/motors/tq-robodrive.csv", include_str!("motors/tq-robodrive.csv")),
];

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    /// A file that is added to a folder is added to the list.
    #[test]
    fn every_file_of_the_folders_is_listed() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let mut found = Vec::new();
        for folder in fs::read_dir(root).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_dir()) {
            let kind = folder.file_name().unwrap().to_string_lossy().into_owned();
            for file in fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
                if file.extension().is_some_and(|e| e == "csv" || e == "toml") {
                    found.push(format!("catalogs/{kind}/{}", file.file_name().unwrap().to_string_lossy()));
                }
            }
        }
        found.sort();
        let listed: Vec<&str> = super::FILES.iter().map(|(name, _)| *name).collect();
        assert_eq!(listed, found);
    }
}
