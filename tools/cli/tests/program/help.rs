use crate::{fixture::folder, run::restpose};

const COMMANDS: [&str; 7] = ["bake", "info", "validate", "verify", "render", "measure", "demo"];

#[test]
fn help_is_a_result_and_lists_the_exit_codes() {
    let folder = folder();
    let pages = COMMANDS
        .iter()
        .flat_map(|command| [vec![*command, "--help"], vec!["help", *command]]);
    let tables =
        ["frame", "tessellations", "motion", "poses", "builders"].map(|table| vec!["measure", table, "--help"]);
    for arguments in pages.chain(tables).chain([vec!["--help"], vec!["-h"], vec!["help"]]) {
        let run = restpose(folder.path(), &arguments).succeeded();
        assert_eq!(run.stderr, "", "{arguments:?}");
        assert!(run.stdout.contains("Usage: restpose"), "{arguments:?}");
        for code in ["  0  done", "  1  ", "  2  ", "  3  ", "  4  ", "  5  ", "  7  "] {
            assert!(run.stdout.contains(code), "{arguments:?} lacks {code:?}");
        }
    }
}

#[test]
fn the_main_page_lists_every_command() {
    let run = restpose(folder().path(), ["--help"]).succeeded();
    for command in COMMANDS {
        assert!(run.stdout.contains(&format!("\n  {command} ")), "{command}");
    }
}

#[test]
fn options_stand_in_groups_with_their_defaults() {
    let run = restpose(folder().path(), ["render", "--help"]).succeeded();
    for words in [
        "Time:",
        "Picture:",
        "Camera:",
        "Global options:",
        "[default: 512x512]",
        "1 to 9999",
    ] {
        assert!(run.stdout.contains(words), "{words}");
    }
    let bake = restpose(folder().path(), ["bake", "--help"]).succeeded();
    for words in [
        "<INPUT>...",
        "Frames of vertex caches and OBJ sequences:",
        "Vertex caches:",
        "--position-error <UNITS>",
        "--max-clusters <N>",
        "Poses:",
        "Trees:",
        "Motion classes:",
    ] {
        assert!(bake.stdout.contains(words), "{words}: {}", bake.stdout);
    }
    assert!(!run.stdout.contains("_frames") && !run.stdout.contains("--if_changed"));
}

#[test]
fn the_version_is_a_result() {
    let run = restpose(folder().path(), ["--version"]).succeeded();
    assert_eq!(run.stdout.trim(), concat!("restpose ", env!("CARGO_PKG_VERSION")));
}
