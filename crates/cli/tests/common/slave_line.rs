//! A slave of the tests on a TCP port.

use super::run;
use profivac_dp::link::Baud;
use profivac_dp::slave::{Device, Slave};
use profivac_host::port::{Port, TcpServer};
use profivac_host::segment::Segment;
use serde_json::Value;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// The address of the slave.
pub const ADDRESS: u8 = 9;

/// A slave on a TCP port. It ends when this is dropped.
pub struct SlaveLine {
    pub address: String,
    end: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl SlaveLine {
    pub fn start<D: Device + Send + 'static>(device: D) -> Self {
        let server = TcpServer::listen("127.0.0.1:0").unwrap();
        let address = server.name().to_owned();
        let end = Arc::new(AtomicBool::new(false));
        let ends = Arc::clone(&end);
        let thread = thread::spawn(move || {
            let slave: Slave<_> = Slave::new(device, ADDRESS, Baud::B19200);
            let mut segment = Segment::new(Box::new(server), Baud::B19200, false, [slave]);
            while !ends.load(Ordering::Relaxed) {
                segment.serve(&[], Duration::from_millis(20)).unwrap();
            }
        });
        Self { address, end, thread: Some(thread) }
    }

    /// The port for the option `--port`.
    pub fn port(&self) -> String {
        format!("tcp://{}", self.address)
    }

    /// Diag_Master_Add.
    pub fn owner(&self) -> Value {
        let scan = run(&["scan", "--port", &self.port(), "--hsa", "9", "--json"]);
        let rows: Value = serde_json::from_slice(&scan.stdout).unwrap();
        rows[0]["owner"].clone()
    }
}

impl Drop for SlaveLine {
    fn drop(&mut self) {
        self.end.store(true, Ordering::Relaxed);
        let ended = self.thread.take().unwrap().join();
        assert!(ended.is_ok() || thread::panicking());
    }
}
