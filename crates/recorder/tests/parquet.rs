//! Samples as a Parquet file.

#![allow(clippy::unwrap_used, reason = "a test")]

use crate::common::keep_everything;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use profivac_recorder::{Chunks, Micros, Quality, Reader, Recorder, Sample, Settings};
use std::fs::File;
use std::sync::Arc;

#[test]
fn a_parquet_file_has_each_sample_with_its_types() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let recorder = Recorder::start(&path, keep_everything()).unwrap();
    let at = |second: i64| Micros((1_767_225_600 + second) * Micros::SECOND + 7);
    for (name, pa) in [("chamber", Some(1.5e-6)), ("é, \"fore\"", None)] {
        let quality = if pa.is_some() { Quality::Valid } else { Quality::Stale };
        // More than one chunk, and more than one row group together.
        for second in 0..120_000 {
            recorder.push(&Arc::from(name), Sample::new(at(second), pa, quality));
            // The recorder's queue is bounded.
            assert!(second % 1_000 != 0 || recorder.flush());
        }
    }
    assert!(recorder.finish());

    let reader = Reader::open(&path).unwrap();
    let names = reader.series_names().unwrap();
    let to = folder.path().join("all.parquet");
    let chunks = Chunks::new(reader, names, Micros(0), Micros(i64::MAX));
    assert_eq!(profivac_recorder::parquet::write(chunks, File::create(&to).unwrap()).unwrap(), 240_000);

    let file = SerializedFileReader::new(File::open(&to).unwrap()).unwrap();
    assert_eq!(file.metadata().num_row_groups(), 2);
    let rows: Vec<Vec<Field>> = file
        .get_row_iter(None)
        .unwrap()
        .map(|row| row.unwrap().into_columns().into_iter().map(|(_, f)| f).collect())
        .collect();
    let row = |second: i64, name: &str, pa: Field, quality: &str| {
        vec![Field::TimestampMicros(at(second).0), Field::Str(name.to_owned()), pa, Field::Str(quality.to_owned())]
    };
    assert_eq!(rows.first(), Some(&row(0, "chamber", Field::Double(1.5e-6), "valid")));
    assert_eq!(rows.get(119_999), Some(&row(119_999, "chamber", Field::Double(1.5e-6), "valid")));
    assert_eq!(rows.get(120_000), Some(&row(0, "é, \"fore\"", Field::Null, "stale")));
    assert_eq!(rows.len(), 240_000);
}

#[test]
fn a_parquet_file_without_samples_has_columns() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    assert!(Recorder::start(&path, Settings::default()).unwrap().finish());
    let chunks = Chunks::new(Reader::open(&path).unwrap(), Vec::new(), Micros(0), Micros(i64::MAX));
    let to = folder.path().join("none.parquet");
    assert_eq!(profivac_recorder::parquet::write(chunks, File::create(&to).unwrap()).unwrap(), 0);
    let file = SerializedFileReader::new(File::open(&to).unwrap()).unwrap();
    assert_eq!(file.metadata().file_metadata().num_rows(), 0);
    assert_eq!(file.metadata().file_metadata().schema_descr().num_columns(), 4);
}
