//! Dependencies run one way: `formats` ← `runtime` ← tools.

use std::{collections::BTreeSet, process::Command};

/// Names of all packages that `package` is built from, itself included.
fn built_from(package: &str) -> BTreeSet<String> {
    let output = Command::new(env!("CARGO"))
        .args([
            "tree",
            "--offline",
            "--locked",
            "--edges",
            "normal,build",
            "--all-features",
            "--prefix",
            "none",
        ])
        .args(["--format", "{p}", "--package", package])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines()
        .filter_map(|line| line.split_whitespace().next())
        .map(str::to_owned)
        .collect()
}

/// Those of `packages` that are ours.
fn ours(packages: &BTreeSet<String>) -> Vec<&str> {
    packages
        .iter()
        .map(String::as_str)
        .filter(|name| name.starts_with("restpose"))
        .collect()
}

#[test]
fn formats_depends_on_nothing_of_ours() {
    assert_eq!(ours(&built_from("restpose-formats")), ["restpose-formats"]);
}

#[test]
fn runtime_depends_on_formats_only() {
    assert_eq!(
        ours(&built_from("restpose-runtime")),
        ["restpose-formats", "restpose-runtime"]
    );
}

#[test]
fn bake_depends_on_formats_runtime_and_builders_only() {
    assert_eq!(
        ours(&built_from("restpose-bake")),
        [
            "restpose-bake",
            "restpose-builders",
            "restpose-formats",
            "restpose-runtime"
        ]
    );
}

#[test]
fn builders_depend_on_formats_and_runtime_only() {
    assert_eq!(
        ours(&built_from("restpose-builders")),
        ["restpose-builders", "restpose-formats", "restpose-runtime"]
    );
}

/// A new name here is a decision about every game that links the runtime, not a side effect.
#[test]
fn runtime_is_built_from_these_packages() {
    // Procedural macros run at build time; nothing of them is linked.
    let macros = [
        "bytemuck_derive",
        "proc-macro2",
        "quote",
        "serde_derive",
        "syn",
        "thiserror-impl",
        "unicode-ident",
    ];
    let linked: Vec<String> = built_from("restpose-runtime")
        .into_iter()
        .filter(|name| !macros.contains(&name.as_str()))
        .collect();
    let expected = [
        "bincode",
        "bytemuck",
        "cfg-if",
        "crc32fast",
        "crossbeam-deque",
        "crossbeam-epoch",
        "crossbeam-utils",
        "either",
        "libc",
        "memmap2",
        "rayon",
        "rayon-core",
        "restpose-formats",
        "restpose-runtime",
        "serde",
        "serde_core",
        "thiserror",
        "unty",
    ];
    assert_eq!(linked, expected);
}
