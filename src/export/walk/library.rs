//! three.js, the WebGL library of the page: the copy that the build put into the program, or one that is named.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Names a copy where it is not typed.
const VARIABLE: &str = "LIGHTSHAFT_THREE";

/// Of the package `three` of npm: the two modules, and its licence.
const FILES: [&str; 3] = ["build/three.module.js", "build/three.core.js", "LICENSE"];

/// What both modules say within their first bytes.
const SIGN: &[u8] = b"Three.js Authors";

/// More than any of the files has, bytes.
const MOST_BYTES: u64 = 16 << 20;

#[cfg(lightshaft_three)]
const BUNDLED: Option<[&str; 3]> = Some([
    include_str!(concat!(env!("LIGHTSHAFT_PROVISIONED_THREE"), "/build/three.module.js")),
    include_str!(concat!(env!("LIGHTSHAFT_PROVISIONED_THREE"), "/build/three.core.js")),
    include_str!(concat!(env!("LIGHTSHAFT_PROVISIONED_THREE"), "/LICENSE")),
]);
#[cfg(not(lightshaft_three))]
const BUNDLED: Option<[&str; 3]> = None;

/// A copy of three.js.
#[derive(Clone, Debug)]
pub struct WebLibrary {
    /// Imports the other one.
    pub(super) module: Cow<'static, str>,
    pub(super) core: Cow<'static, str>,
    /// Its terms, which go where it goes.
    pub(super) licence: Cow<'static, str>,
}

/// Why there is no three.js.
#[derive(Debug, thiserror::Error)]
pub enum WebLibraryError {
    /// The build had none, and none is named.
    #[error(
        "this build has no three.js, which --html needs: give --three or {VARIABLE} the folder of the npm package `three` \
         (`npm pack three`, then `tar xf` makes one, named `package`), or build again where npm or pip can be used"
    )]
    Missing,
    /// A file of a named copy cannot be read.
    #[error("{}: {source}; --three and {VARIABLE} take the folder of the npm package `three`", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A named copy is something else.
    #[error("{}: no module of three.js (release 172 or later)", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
    },
}

impl WebLibrary {
    /// The copy in this folder; where there is none, in the folder that the variable `LIGHTSHAFT_THREE` names; where that is
    /// not set, the one in the program.
    ///
    /// # Errors
    /// When there is none, or not three.js in what is named; nothing else is tried then.
    pub fn find(typed: Option<&Path>) -> Result<WebLibrary, WebLibraryError> {
        let named = std::env::var_os(VARIABLE).filter(|value| !value.is_empty()).map(PathBuf::from);
        match typed.or(named.as_deref()) {
            Some(folder) => WebLibrary::read(folder),
            None => {
                let [module, core, licence] = BUNDLED.ok_or(WebLibraryError::Missing)?.map(Cow::Borrowed);
                Ok(WebLibrary { module, core, licence })
            }
        }
    }

    fn read(folder: &Path) -> Result<WebLibrary, WebLibraryError> {
        let text = |name: &str| {
            let path = folder.join(name);
            let mut bytes = Vec::new();
            let read = File::open(&path).and_then(|file| file.take(MOST_BYTES + 1).read_to_end(&mut bytes));
            match read {
                Err(source) => Err(WebLibraryError::Unreadable { path, source }),
                Ok(_) if bytes.len() as u64 > MOST_BYTES => Err(WebLibraryError::Foreign { path }),
                Ok(_) => {
                    String::from_utf8(bytes).map(Cow::Owned).map_err(|_| WebLibraryError::Foreign { path })
                }
            }
        };
        let [module, core, licence] = FILES.map(text);
        let library = WebLibrary { module: module?, core: core?, licence: licence? };
        for (name, module) in FILES.iter().zip([&library.module, &library.core]) {
            let begin = &module.as_bytes()[..module.len().min(500)];
            if !begin.windows(SIGN.len()).any(|window| window == SIGN) {
                return Err(WebLibraryError::Foreign { path: folder.join(name) });
            }
        }
        Ok(library)
    }
}
