//! The library in use: found, opened, checked.

use std::{
    fmt,
    path::{Path, PathBuf},
    sync::Arc,
};

use embree4_sys as raw;

use super::{
    device::Device,
    error::{Attempt, EmbreeError, Origin, Refusal},
    search::{Step, Surroundings, mapped_file},
    selftest::{self, SelfTest},
};

/// Oldest version with the struct layout of our declarations.
const OLDEST: Version = Version { major: 4, minor: 3, patch: 0 };
/// The first major version that is not Embree 4.
const TOO_NEW: u32 = 5;

/// An Embree that passed every check. It stays loaded until the end of the process.
#[derive(Debug)]
pub struct EmbreeLibrary {
    api: Arc<raw::Api>,
    path: PathBuf,
    origin: Origin,
    version: Version,
    instruction_set: InstructionSet,
    task_system: TaskSystem,
    self_tests: Vec<SelfTest>,
    refused: Vec<Attempt>,
}

impl EmbreeLibrary {
    /// Looks for a library that fits, in this order: `option` (what the user gave as `--embree-lib`: a
    /// file, a folder with `libembree4` in it, or a name for the system's loader), the variable
    /// `LIGHTSHAFT_EMBREE_LIB` (the same), `EMBREE_DIR/lib*`, beside the executable and `../lib`, what
    /// the build provisioned, the system. When one of the first two is given, no other is tried.
    ///
    /// The library must be 4.3 or later, below 5, and pass the [self-tests](Self::self_tests).
    ///
    /// # Errors
    /// [`EmbreeError::NotFound`] with every place tried and why it did not fit.
    pub fn find(option: Option<&Path>) -> Result<Arc<Self>, EmbreeError> {
        Self::find_in(&Surroundings::of_process(option))
    }

    pub(super) fn find_in(surroundings: &Surroundings) -> Result<Arc<Self>, EmbreeError> {
        let mut tried = Vec::new();
        for step in surroundings.steps() {
            match step {
                Step::Skip(attempt) => tried.push(attempt),
                Step::Open(origin, path) => match Self::open(origin, &path) {
                    Ok(mut library) => {
                        library.refused = tried;
                        return Ok(Arc::new(library));
                    }
                    Err(refusal) => tried.push(Attempt { origin, place: Some(path), refusal }),
                },
            }
        }
        Err(EmbreeError::NotFound { tried })
    }

    fn open(origin: Origin, path: &Path) -> Result<Self, Refusal> {
        // SAFETY: the file is one the user or the system presents as Embree 4; before any function
        // beyond device and properties is called, the version is checked below.
        let api = unsafe { raw::open(path) }.map_err(Refusal::NotLoadable)?;
        let api = Arc::new(api);
        let device = Device::new(&api, 1).map_err(Refusal::NoDevice)?;
        let version = version_of(&device);
        if version < OLDEST || version.major >= TOO_NEW {
            return Err(Refusal::Version(version));
        }
        let filter = raw::RTCDeviceProperty::RTC_DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED;
        if device.property(filter) == 0 {
            return Err(Refusal::NoFilter);
        }
        let self_tests = selftest::run(&api)?;
        let place = mapped_file(api.rtcNewDevice as usize).unwrap_or_else(|| path.to_owned());
        Ok(EmbreeLibrary {
            path: place,
            origin,
            version,
            instruction_set: InstructionSet::of(&device),
            task_system: TaskSystem::of(&device),
            self_tests,
            refused: Vec::new(),
            api,
        })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// How it was found.
    pub fn origin(&self) -> Origin {
        self.origin
    }

    /// Its version.
    pub fn version(&self) -> Version {
        self.version
    }

    /// What its kernels run on.
    pub fn instruction_set(&self) -> InstructionSet {
        self.instruction_set
    }

    /// What runs its builds in parallel.
    pub fn task_system(&self) -> TaskSystem {
        self.task_system
    }

    /// The self-tests it passed.
    pub fn self_tests(&self) -> &[SelfTest] {
        &self.self_tests
    }

    /// Places tried before it, and why they did not fit.
    pub fn refused(&self) -> &[Attempt] {
        &self.refused
    }

    pub(super) fn api(&self) -> &Arc<raw::Api> {
        &self.api
    }
}

impl fmt::Display for EmbreeLibrary {
    /// `Embree 4.4.0 (system: /usr/lib/libembree4.so.4)`, for the log.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Embree {} ({}: {})", self.version, self.origin, self.path.display())
    }
}

fn version_of(device: &Device) -> Version {
    let part = |property| u32::try_from(device.property(property)).unwrap_or(0);
    Version {
        major: part(raw::RTCDeviceProperty::RTC_DEVICE_PROPERTY_VERSION_MAJOR),
        minor: part(raw::RTCDeviceProperty::RTC_DEVICE_PROPERTY_VERSION_MINOR),
        patch: part(raw::RTCDeviceProperty::RTC_DEVICE_PROPERTY_VERSION_PATCH),
    }
}

/// Version of a library.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Version {
    /// 4.
    pub major: u32,
    /// At least 3 in a library that is used.
    pub minor: u32,
    /// Any.
    pub patch: u32,
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}.{}", self.major, self.minor, self.patch)
    }
}

/// What the library's kernels run on, as far as it tells: the widest packet it traces natively.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InstructionSet {
    /// Rays in that packet: 16, 8, 4, or 0 for none.
    pub packet_width: u32,
}

impl InstructionSet {
    fn of(device: &Device) -> Self {
        let widths = [
            (16, raw::RTCDeviceProperty::RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED),
            (8, raw::RTCDeviceProperty::RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED),
            (4, raw::RTCDeviceProperty::RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED),
        ];
        let widest = widths.into_iter().find(|&(_, property)| device.property(property) != 0);
        InstructionSet { packet_width: widest.map_or(0, |(width, _)| width) }
    }

    /// The set that this width means. Embree does not say more: AVX and AVX2 have the same width.
    pub fn name(&self) -> &'static str {
        match self.packet_width {
            16 => "AVX-512",
            8 if cfg!(target_arch = "aarch64") => "NEON",
            8 if has_avx2() => "AVX2 or AVX",
            8 => "AVX",
            4 if cfg!(target_arch = "aarch64") => "NEON",
            4 => "SSE",
            _ => "unknown",
        }
    }
}

impl fmt::Display for InstructionSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.packet_width {
            0 => write!(f, "unknown (no native packets)"),
            width => write!(f, "{} (native packets of {width} rays)", self.name()),
        }
    }
}

#[cfg(target_arch = "x86_64")]
fn has_avx2() -> bool {
    std::arch::is_x86_feature_detected!("avx2")
}

#[cfg(not(target_arch = "x86_64"))]
fn has_avx2() -> bool {
    false
}

/// What runs the library's builds in parallel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskSystem {
    /// Its own scheduler.
    Internal,
    /// Intel's Threading Building Blocks.
    Tbb,
    /// Microsoft's Parallel Patterns Library.
    Ppl,
    /// A number this version of lightshaft does not know.
    Unknown(isize),
}

impl TaskSystem {
    fn of(device: &Device) -> Self {
        match device.property(raw::RTCDeviceProperty::RTC_DEVICE_PROPERTY_TASKING_SYSTEM) {
            0 => TaskSystem::Internal,
            1 => TaskSystem::Tbb,
            2 => TaskSystem::Ppl,
            other => TaskSystem::Unknown(other),
        }
    }
}

impl fmt::Display for TaskSystem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TaskSystem::Internal => f.write_str("internal"),
            TaskSystem::Tbb => f.write_str("TBB"),
            TaskSystem::Ppl => f.write_str("PPL"),
            TaskSystem::Unknown(number) => write!(f, "unknown ({number})"),
        }
    }
}
