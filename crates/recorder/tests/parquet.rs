//! Samples as a Parquet file.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::common::keep_everything;
use parquet::basic::{ColumnOrder, Compression, SortOrder};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::statistics::Statistics;
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
    recorder.finish().unwrap();

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

/// Statistics of a column whose order a reader does not know are ignored; and many readers decode Snappy, few of them GZIP.
#[test]
fn a_parquet_file_has_a_codec_and_statistics_that_every_reader_knows() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let recorder = Recorder::start(&path, keep_everything()).unwrap();
    for (second, pa) in [(1, Some(2e-3)), (2, None), (3, Some(5e-7))] {
        let quality = if pa.is_some() { Quality::Valid } else { Quality::Off };
        recorder.push(&Arc::from("chamber"), Sample::new(Micros(second * Micros::SECOND), pa, quality));
    }
    recorder.finish().unwrap();
    let chunks = Chunks::new(Reader::open(&path).unwrap(), vec!["chamber".to_owned()], Micros(0), Micros(i64::MAX));
    let to = folder.path().join("some.parquet");
    profivac_recorder::parquet::write(chunks, File::create(&to).unwrap()).unwrap();

    let file = SerializedFileReader::new(File::open(&to).unwrap()).unwrap();
    let metadata = file.metadata();
    let columns = metadata.row_group(0).columns();
    assert!(columns.iter().all(|column| column.compression() == Compression::SNAPPY), "{columns:?}");
    let pressure = (0..columns.len()).find(|index| columns[*index].column_path().string() == "pressure_pa").unwrap();
    let orders = metadata.file_metadata().column_orders().unwrap();
    assert_eq!(orders[pressure], ColumnOrder::TYPE_DEFINED_ORDER(SortOrder::SIGNED));
    let Some(Statistics::Double(found)) = columns[pressure].statistics() else { panic!("no statistics") };
    assert_eq!((found.min_opt(), found.max_opt(), found.null_count_opt()), (Some(&5e-7), Some(&2e-3), Some(1)));
}

#[test]
fn a_parquet_file_without_samples_has_columns() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    Recorder::start(&path, Settings::default()).unwrap().finish().unwrap();
    let chunks = Chunks::<String>::new(Reader::open(&path).unwrap(), Vec::new(), Micros(0), Micros(i64::MAX));
    let to = folder.path().join("none.parquet");
    assert_eq!(profivac_recorder::parquet::write(chunks, File::create(&to).unwrap()).unwrap(), 0);
    let file = SerializedFileReader::new(File::open(&to).unwrap()).unwrap();
    assert_eq!(file.metadata().file_metadata().num_rows(), 0);
    assert_eq!(file.metadata().file_metadata().schema_descr().num_columns(), 4);
}
