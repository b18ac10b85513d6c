//! The batches that a station sends to the archive: any octets, and any octets after decompression.
//!
//! A batch that is accepted gives samples or a clear error, and is the same after it is written and read again.

use profivac_recorder::batch::Batch;

/// Runs the target: octets as they arrive, then the same octets compressed first.
pub fn run(octets: &[u8]) {
    check(octets);
    check(&stored(octets));
}

/// Deflate without compression: blocks of up to 65535 octets.
fn stored(octets: &[u8]) -> Vec<u8> {
    let mut blocks: Vec<&[u8]> = octets.chunks(usize::from(u16::MAX)).collect();
    if blocks.is_empty() {
        blocks.push(&[]);
    }
    let last = blocks.len() - 1;
    let mut packed = Vec::new();
    for (number, block) in blocks.into_iter().enumerate() {
        let length = u16::try_from(block.len()).unwrap_or_default();
        packed.push(u8::from(number == last));
        packed.extend(length.to_le_bytes());
        packed.extend((!length).to_le_bytes());
        packed.extend(block);
    }
    packed
}

fn check(octets: &[u8]) {
    let Ok(batch) = Batch::decode_compressed(octets) else { return };
    for series in &batch.samples {
        if let Ok(samples) = series.unpack() {
            assert_eq!(samples.len(), series.steps_us.len());
        }
    }
    let again = batch.encode_compressed().expect("written to memory");
    let again = Batch::decode_compressed(&again).expect("a batch that this program has written");
    // Not a number differs from itself.
    assert_eq!(format!("{again:?}"), format!("{batch:?}"));
}
