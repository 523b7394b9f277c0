//! `tools/IMPORT.md` names tests that exist, and every test but those of real scenes is named.

use std::{collections::BTreeSet, fs, path::Path};

#[test]
fn the_table_names_every_test() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let table = fs::read_to_string(package.join("../IMPORT.md")).unwrap();
    let named: BTreeSet<String> = table
        .split('`')
        .filter(|code| code.contains("::") && !code.starts_with("restpose"))
        .map(str::to_owned)
        .collect();
    let mut existing = BTreeSet::new();
    for entry in fs::read_dir(package.join("tests/import")).unwrap() {
        let path = entry.unwrap().path();
        let module = path.file_stem().unwrap().to_str().unwrap().to_owned();
        if module == "scenes" || module == "table" {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        for test in text.split("#[test]\nfn ").skip(1) {
            existing.insert(format!("{module}::{}", test.split('(').next().unwrap()));
        }
    }
    assert_eq!(
        named.difference(&existing).collect::<Vec<_>>(),
        Vec::<&String>::new(),
        "named, but missing"
    );
    assert_eq!(
        existing.difference(&named).collect::<Vec<_>>(),
        Vec::<&String>::new(),
        "not named"
    );
}
