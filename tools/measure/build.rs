//! Links Embree, where peers are asked for.

fn main() {
    if std::env::var_os("CARGO_FEATURE_PEERS").is_some() {
        println!("cargo:rustc-link-lib=embree3");
    }
    println!("cargo:rerun-if-changed=build.rs");
}
