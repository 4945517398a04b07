//! Names the shared library: programs that link it look for this name when they start.

/// Prints the name, with the version that keeps the interface: before 1.0 each minor one is
/// another.
fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "linux") {
        let major = env!("CARGO_PKG_VERSION_MAJOR");
        let minor = if major == "0" { concat!(".", env!("CARGO_PKG_VERSION_MINOR")) } else { "" };
        println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libantumbra.so.{major}{minor}");
    }
}
