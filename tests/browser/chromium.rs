//! A Chromium without a window, driven over the DevTools protocol.

use crate::tab::Tab;
use std::fs::read_to_string;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Names that a Chromium has.
const NAMES: [&str; 5] =
    ["chromium", "chromium-browser", "google-chrome-stable", "google-chrome", "chrome"];
/// No window, no graphics card, a fresh profile, and no traffic of the browser's own.
const FLAGS: [&str; 11] = [
    "--headless",
    "--hide-scrollbars",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--remote-debugging-port=0",
];
/// Longest time for the browser to begin and to end.
const PATIENCE: Duration = Duration::from_secs(60);

/// A browser that runs until this is dropped.
pub struct Chromium {
    process: Child,
    address: String,
    /// Its profile, removed after it has ended.
    _profile: tempfile::TempDir,
}

/// The binary that `LACUNA_CHROMIUM` names, else the first on the path.
fn find() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("LACUNA_CHROMIUM") {
        let named = PathBuf::from(named);
        assert!(named.is_file(), "LACUNA_CHROMIUM names no file: {}", named.display());
        return Some(named);
    }
    let path = std::env::var_os("PATH")?;
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    let all = NAMES.iter().flat_map(|name| folders.iter().map(move |f| f.join(name)));
    all.into_iter().find(|p| p.is_file())
}

impl Chromium {
    /// A browser, where there is one.
    pub fn found() -> Option<Self> {
        let binary = find();
        if binary.is_none() {
            eprintln!("skipped: no Chromium on the path, and LACUNA_CHROMIUM names none");
        }
        Some(Self::start(&binary?))
    }

    fn start(binary: &PathBuf) -> Self {
        let profile = tempfile::tempdir().unwrap();
        let process = Command::new(binary)
            .args(FLAGS)
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg("about:blank")
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        // The port and the path of the DevTools' socket, one on each line.
        let file = profile.path().join("DevToolsActivePort");
        let begin = Instant::now();
        let address = loop {
            let text = read_to_string(&file).unwrap_or_default();
            if let Some((port, path)) = text.split_once('\n').filter(|(_, path)| !path.is_empty()) {
                break format!("ws://127.0.0.1:{port}{}", path.trim());
            }
            assert!(begin.elapsed() < PATIENCE, "{} does not begin", binary.display());
            std::thread::sleep(Duration::from_millis(50));
        };
        Self { process, address, _profile: profile }
    }

    /// A new empty tab.
    pub fn tab(&self) -> Tab {
        Tab::open(&self.address)
    }
}

impl Drop for Chromium {
    fn drop(&mut self) {
        Tab::close_browser(&self.address);
        let begin = Instant::now();
        while begin.elapsed() < PATIENCE {
            if matches!(self.process.try_wait(), Ok(Some(_))) {
                return;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
