//! Records as JSON files. `docs/stats.md` is the schema of the statistics, `docs/probe.md` that of probes.

use std::path::Path;

use serde::Serialize;

use crate::image::write::{FillError, OutputError, write_atomically};

/// Writes a record to `path`, whole or not at all, replacing what is there.
///
/// # Errors
/// When the folder is missing or not writable or the disk is full.
pub fn write_json(path: &Path, record: &impl Serialize) -> Result<(), OutputError> {
    write_atomically(path, |file| -> Result<(), FillError> {
        let encode = |error: serde_json::Error| match error.io_error_kind() {
            Some(kind) => FillError::Io(kind.into()),
            None => FillError::Encode(error.to_string()),
        };
        serde_json::to_writer_pretty(&mut *file, record).map_err(encode)?;
        file.write_all(b"\n").map_err(FillError::Io)
    })
}

#[cfg(test)]
mod tests {
    use super::super::stats::Stats;
    use super::*;

    #[test]
    fn what_is_written_reads_back() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("stats.json");
        let mut stats = Stats { tracer: "fallback".into(), threads: 3, ..Stats::default() };
        stats.links.total = u64::from(u32::MAX) + 7;
        stats.energy.balance_error = 0.001_25;
        write_json(&path, &stats).expect("written");
        let text = std::fs::read_to_string(&path).expect("readable");
        let read: Stats = serde_json::from_str(&text).expect("valid");
        assert_eq!((read.tracer.as_str(), read.threads), ("fallback", 3));
        assert_eq!(read.links.total, u64::from(u32::MAX) + 7);
        assert_eq!(read.energy.balance_error, 0.001_25);
        assert!(text.ends_with("}\n"));
    }

    #[test]
    fn every_field_is_in_the_documented_schema() {
        let documented = include_str!("../../docs/stats.md");
        let all = Stats {
            reference: Some(Default::default()),
            relit: Some(Default::default()),
            local_pass: Some(Default::default()),
            ..Stats::default()
        };
        let value = serde_json::to_value(all).expect("serialisable");
        let mut names = Vec::new();
        for (name, inner) in value.as_object().expect("a record") {
            names.push(name.clone());
            names.extend(inner.as_object().into_iter().flatten().map(|(field, _)| format!("{name}.{field}")));
        }
        assert!(names.len() > 40, "the record has lost fields: {names:?}");
        for name in names {
            assert!(documented.contains(&format!("| `{name}` |")), "docs/stats.md does not explain {name}");
        }
    }
}
