//! Finds Ceres and compiles `cpp/`. Without the feature `ceres` it compiles nothing; without the libraries it says so
//! once and leaves the Rust solver alone.

use std::env;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-check-cfg=cfg(ceres_linked)");
    for name in ["HITL_CERES_DIR", "HITL_REQUIRE_CERES", "CXX", "CXXFLAGS", "DOCS_RS"] {
        println!("cargo:rerun-if-env-changed={name}");
    }
    let back_ends = match ceres() {
        Ok(version) => {
            println!("cargo:rustc-cfg=ceres_linked");
            format!("rust, ceres {version}")
        }
        Err(reason) => {
            if env::var("HITL_REQUIRE_CERES").is_ok_and(|v| v == "1") {
                println!("cargo::error={reason} HITL_REQUIRE_CERES=1 asks for it.");
                std::process::exit(1);
            }
            if cfg!(feature = "ceres") {
                println!(
                    "cargo:warning={reason} Building with the Rust solver only. On Debian or Ubuntu: apt install \
                     libceres-dev. HITL_REQUIRE_CERES=1 makes this an error, --no-default-features silences it."
                );
            }
            let why =
                if cfg!(feature = "ceres") { "not found when it was built" } else { "built without it" };
            format!("rust (no ceres: {why})")
        }
    };
    println!("cargo:rustc-env=HITL_BACK_ENDS={back_ends}");
}

#[cfg(not(feature = "ceres"))]
fn ceres() -> Result<String, String> {
    Err("The feature `ceres` is off.".into())
}

/// Compiles the shim; the version of Ceres found.
#[cfg(feature = "ceres")]
fn ceres() -> Result<String, String> {
    const SOURCES: [&str; 4] =
        ["cpp/ceres_backend.cc", "cpp/log_capture.cc", "cpp/polish.cc", "cpp/terms.cc"];
    const HEADERS: [&str; 6] = [
        "cpp/ceres_backend.h",
        "cpp/jets.h",
        "cpp/log_capture.h",
        "cpp/polish.h",
        "cpp/residuals.h",
        "cpp/terms.h",
    ];
    println!("cargo:rerun-if-changed=src/joint/ceres/bridge.rs");
    for file in SOURCES.iter().chain(&HEADERS) {
        println!("cargo:rerun-if-changed={file}");
    }
    if env::var_os("DOCS_RS").is_some() {
        // rustdoc does not link: document the bridge without compiling C++.
        return Ok("(documentation only)".into());
    }
    let found = find::ceres()?;
    let mut build = cxx_build::bridge("src/joint/ceres/bridge.rs");
    // Eigen and Ceres as system headers, so that only our own warnings show. Optimised in every profile: automatic
    // differentiation at -O0 is several times slower. Never -march=native: Eigen's alignment is part of libceres' ABI.
    build
        .files(SOURCES)
        .std("c++17")
        .flag("-isystem")
        .flag(&found.eigen)
        .flags(["-Wall", "-Wextra", "-Wconversion"])
        .define("GLOG_USE_GLOG_EXPORT", None)
        .opt_level(2);
    // The compiler's own folder must not be named: libstdc++ would no longer find its C headers.
    if found.include != "/usr/include" {
        build.flag("-isystem").flag(&found.include);
    }
    build.try_compile("hitl-ceres").map_err(|e| format!("Ceres was found, but does not compile: {e}"))?;
    if let Some(folder) = found.library_folder {
        println!("cargo:rustc-link-search=native={folder}");
    }
    println!("cargo:rustc-link-lib=dylib=ceres");
    println!("cargo:rustc-link-lib=dylib=glog");
    Ok(found.version)
}

#[cfg(feature = "ceres")]
mod find {
    use std::env;
    use std::path::Path;
    use std::process::Command;

    /// Where things are.
    pub struct Found {
        pub include: String,
        pub eigen: String,
        pub library_folder: Option<String>,
        pub version: String,
    }

    /// Ceres ≥ 2.1 with Eigen and glog: under `HITL_CERES_DIR` if that is set, else where systems put them. Ceres has
    /// no pkg-config file: the header tells its version, the compiler where the libraries are.
    pub fn ceres() -> Result<Found, String> {
        let given = env::var("HITL_CERES_DIR").ok().filter(|dir| !dir.is_empty());
        let roots = match &given {
            Some(dir) => vec![dir.clone()],
            None => ["/usr", "/usr/local", "/opt/homebrew"].map(String::from).to_vec(),
        };
        let header = |root: &&String| Path::new(*root).join("include/ceres/version.h").is_file();
        let Some(root) = roots.iter().find(header) else {
            return Err(format!("Ceres headers not found (looked in {}).", looked_in(&roots)));
        };
        let version = version(&format!("{root}/include/ceres/version.h"))?;
        let Some(eigen) = [root.as_str(), "/usr", "/usr/local", "/opt/homebrew"]
            .iter()
            .map(|r| format!("{r}/include/eigen3"))
            .find(|dir| Path::new(dir).join("Eigen/Core").is_file())
        else {
            return Err("Ceres was found, but Eigen's headers were not.".into());
        };
        let library_folder = given.map(|dir| format!("{dir}/lib"));
        for library in ["ceres", "glog"] {
            if !library_found(library, library_folder.as_deref()) {
                return Err(format!("Ceres headers were found, but lib{library} was not."));
            }
        }
        Ok(Found { include: format!("{root}/include"), eigen, library_folder, version })
    }

    fn looked_in(roots: &[String]) -> String {
        roots.iter().map(|r| format!("{r}/include")).collect::<Vec<_>>().join(", ")
    }

    fn version(header: &str) -> Result<String, String> {
        let text = std::fs::read_to_string(header).map_err(|e| format!("{header}: {e}."))?;
        let number = |name: &str| {
            let line = text.lines().find(|l| l.starts_with("#define") && l.contains(name))?;
            line.split_whitespace().nth(2)?.parse::<u32>().ok()
        };
        let [Some(major), Some(minor), Some(revision)] =
            ["CERES_VERSION_MAJOR", "CERES_VERSION_MINOR", "CERES_VERSION_REVISION"].map(number)
        else {
            return Err(format!("{header}: found no version."));
        };
        if (major, minor) < (2, 1) {
            return Err(format!("Ceres {major}.{minor} was found, expected 2.1 or newer."));
        }
        Ok(format!("{major}.{minor}.{revision}"))
    }

    /// Asks the compiler, which knows its own search path.
    fn library_found(library: &str, folder: Option<&str>) -> bool {
        let names = [format!("lib{library}.so"), format!("lib{library}.dylib"), format!("lib{library}.a")];
        if folder.is_some_and(|f| names.iter().any(|n| Path::new(f).join(n).is_file())) {
            return true;
        }
        let compiler = env::var("CXX").unwrap_or_else(|_| "c++".into());
        names.iter().any(|name| {
            let found = Command::new(&compiler).arg(format!("-print-file-name={name}")).output();
            found.is_ok_and(|o| Path::new(String::from_utf8_lossy(&o.stdout).trim()).is_absolute())
        })
    }
}
