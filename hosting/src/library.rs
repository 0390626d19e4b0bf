//! The shared object of a component. No other code calls the functions of its glue.
#![allow(
    unsafe_code,
    reason = "functions of a shared object are called by the prototypes that its glue was written with"
)]

use std::ffi::{CString, c_char, c_int, c_void};
use std::io;
use std::path::Path;
use std::sync::{Mutex, OnceLock};

use dotgen_analysis::model::PortId;
use dotgen_codegen::codels::glue::ENTRIES;
use dotgen_runtime::hosts::{CodelEnd, PortWrite};
use libloading::Library;

use super::shared_data::View;

/// `struct glue_buffer`
#[repr(C)]
struct Buffer {
    bytes: *mut u8,
    size: usize,
    room: usize,
}

type CreateFn = unsafe extern "C" fn(u32, u32, *const c_void, usize) -> c_int;
type RunFn = unsafe extern "C" fn(u32, u32, *mut Buffer);
type EndFn = unsafe extern "C" fn(u32, u32, *mut Buffer);
type ShareFn = unsafe extern "C" fn(u32, *const c_char, *const c_void) -> *const c_void;
type PutFn = unsafe extern "C" fn(*mut c_void, *const c_void, usize);
type RequestFn = unsafe extern "C" fn(u32, *const c_void, usize, PutFn, *mut c_void) -> c_int;
type SetRequestFn = unsafe extern "C" fn(RequestFn);
type FreeFn = unsafe extern "C" fn(*mut Buffer);

/// A function that calls a service of another component: from a remote and its inputs to the outputs, or a
/// system error.
pub(super) type RemoteCall = Box<dyn Fn(u32, &[u8]) -> Result<Vec<u8>, c_int> + Send + Sync>;

/// Set once, before codels run.
pub(super) static REMOTE_CALL: OnceLock<RemoteCall> = OnceLock::new();

/// Handles a request of the glue.
unsafe extern "C" fn ask(
    remote: u32,
    inputs: *const c_void,
    size: usize,
    put: PutFn,
    to: *mut c_void,
) -> c_int {
    let Some(bring) = REMOTE_CALL.get() else {
        return libc::ENOSYS;
    };
    let inputs = if inputs.is_null() {
        &[]
    } else {
        unsafe { std::slice::from_raw_parts(inputs.cast::<u8>(), size) }
    };
    match bring(remote, inputs) {
        Ok(outputs) => {
            // SAFETY: the function of the glue copies `outputs.len()` bytes to the address that it was called
            // with.
            unsafe { put(to, outputs.as_ptr().cast(), outputs.len()) };
            0
        }
        Err(error) => error,
    }
}

/// The result of a codel.
pub(super) struct CodelOutcome {
    pub(super) how: CodelEnd,
    pub(super) name: String,
    pub(super) detail: Vec<u8>,
    pub(super) written: Vec<PortWrite>,
}

/// A component. Many threads may call it: its glue has a lock.
pub(super) struct Component {
    make: CreateFn,
    run: RunFn,
    end: EndFn,
    share: ShareFn,
    forget: FreeFn,
    /// The mappings in which the glue reads data of ports.
    views: Mutex<Vec<View>>,
    /// Must be dropped after the functions.
    _library: Library,
}

impl Component {
    /// Loads the shared object, which runs its constructors.
    pub(super) fn load(path: &Path) -> Result<Component, String> {
        let wrong = |error: libloading::Error| {
            use std::error::Error as _;
            let why = error.source().map(ToString::to_string);
            why.unwrap_or_else(|| error.to_string())
        };
        // SAFETY: dotgen built the object from the codels that the user wants to run.
        unsafe {
            let library = Library::new(path).map_err(wrong)?;
            let [make, run, end, share, forget, asks] = ENTRIES;
            library.get::<SetRequestFn>(asks).map_err(wrong)?(ask);
            Ok(Component {
                make: *library.get::<CreateFn>(make).map_err(wrong)?,
                run: *library.get::<RunFn>(run).map_err(wrong)?,
                end: *library.get::<EndFn>(end).map_err(wrong)?,
                share: *library.get::<ShareFn>(share).map_err(wrong)?,
                forget: *library.get::<FreeFn>(forget).map_err(wrong)?,
                views: Mutex::default(),
                _library: library,
            })
        }
    }

    pub(super) fn make(&self, service: u32, instance: u32, inputs: &[u8]) {
        // SAFETY: the bytes are only read, within their size.
        unsafe {
            (self.make)(service, instance, inputs.as_ptr().cast(), inputs.len());
        }
    }

    /// Gives an input port the address of its data.
    ///
    /// # Errors
    /// The shared memory cannot be opened.
    pub(super) fn share(&self, port: PortId, id: &str, path: &str) -> io::Result<()> {
        let id = CString::new(id)?;
        let view = View::open(path)?;
        let address = view.address();
        let mut views = self.views.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        views.push(view);
        // SAFETY: the name ends with a zero and is only read. The view keeps its address until the glue
        // returns it.
        let before = unsafe { (self.share)(port.0, id.as_ptr(), address) };
        views.retain(|view| view.address() != before);
        Ok(())
    }

    pub(super) fn end(&self, service: u32, instance: u32) -> Vec<u8> {
        // SAFETY: the function adds to a buffer, which `filled` provides.
        self.filled(|buffer| unsafe { (self.end)(service, instance, buffer) })
    }

    pub(super) fn run(&self, codel: u32, instance: u32) -> CodelOutcome {
        // SAFETY: as above. The codel itself may do anything: this is the reason for a process of its own.
        let bytes = self.filled(|buffer| unsafe { (self.run)(codel, instance, buffer) });
        outcome(&bytes).unwrap_or(CodelOutcome {
            how: CodelEnd::Other,
            name: "nothing came of it".to_owned(),
            detail: Vec::new(),
            written: Vec::new(),
        })
    }

    fn filled(&self, fill: impl FnOnce(*mut Buffer)) -> Vec<u8> {
        let mut buffer = Buffer { bytes: std::ptr::null_mut(), size: 0, room: 0 };
        fill(&raw mut buffer);
        if buffer.bytes.is_null() {
            return Vec::new();
        }
        // SAFETY: the glue has allocated at least `size` bytes, and frees them only in `forget`.
        unsafe {
            let bytes = std::slice::from_raw_parts(buffer.bytes, buffer.size).to_vec();
            (self.forget)(&raw mut buffer);
            bytes
        }
    }
}

fn outcome(bytes: &[u8]) -> Option<CodelOutcome> {
    let mut reader = ByteReader(bytes);
    let how = match reader.number()? {
        0 => CodelEnd::Event,
        1 => CodelEnd::Exception,
        _ => CodelEnd::Other,
    };
    let name = reader.text()?;
    let detail = reader.bytes()?.to_vec();
    let count = reader.number()?;
    let mut written = Vec::new();
    for _ in 0..count {
        let port = PortId(reader.number()?);
        let id = reader.text()?;
        let data = match reader.number()? {
            0 => Some(reader.bytes()?.to_vec()),
            _ => None,
        };
        written.push(PortWrite { port, id, data });
    }
    Some(CodelOutcome { how, name, detail, written })
}

/// Reads values from the bytes that the glue of a component writes, in order. `None` if there are too few.
struct ByteReader<'b>(&'b [u8]);

impl<'b> ByteReader<'b> {
    fn number(&mut self) -> Option<u32> {
        let (number, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(u32::from_le_bytes(*number))
    }

    fn bytes(&mut self) -> Option<&'b [u8]> {
        let length = self.number()? as usize;
        let (bytes, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(bytes)
    }

    fn text(&mut self) -> Option<String> {
        self.bytes().map(|bytes| String::from_utf8_lossy(bytes).into_owned())
    }
}
