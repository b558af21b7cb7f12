//! What the program runs on, for charts of times.

use crate::output;
use std::path::Path;

/// Processor, cores, vector instructions and version, in one line.
pub(crate) fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let cores = if cores == 1 { "1 core".to_owned() } else { format!("{cores} cores") };
    format!("{}, {cores}, {}; morpho-fit {}", processor(), vectors(), env!("CARGO_PKG_VERSION"))
}

/// The processor by its name where the system tells it, else by its kind.
fn processor() -> String {
    let known = output::read(Path::new("/proc/cpuinfo")).unwrap_or_default();
    let known = String::from_utf8_lossy(&known);
    let name = known.lines().find_map(|line| line.strip_prefix("model name"));
    let name = name.and_then(|rest| rest.split_once(':')).map(|(_, name)| name.trim().to_owned());
    name.filter(|name| !name.is_empty()).unwrap_or_else(|| std::env::consts::ARCH.to_owned())
}

/// The widest instructions that the library is built for and the machine has.
fn vectors() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        if std::is_x86_feature_detected!("avx512f") && std::is_x86_feature_detected!("avx512dq") {
            return "AVX-512";
        }
        if std::is_x86_feature_detected!("avx2") {
            return "AVX2";
        }
        "SSE2"
    }
    #[cfg(not(target_arch = "x86_64"))]
    "portable instructions"
}
