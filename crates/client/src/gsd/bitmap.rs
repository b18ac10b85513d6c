//! The bitmaps of a GSD file: 70 x 40 points, 16 colours, drawn by this module.

use profivac_devices::model::{Field, Model};
use profivac_gsd::General;

/// The size that the GSD specification asks for.
const WIDTH: usize = 70;
const HEIGHT: usize = 40;

/// The octets of a row: two points in an octet, padded to a multiple of four.
const ROW: usize = WIDTH.div_ceil(8) * 4;

/// The sizes of the two headers and of the colour table.
const FILE_HEADER: u32 = 14;
const INFO_HEADER: u32 = 40;
const COLOUR_TABLE: u32 = 64;

/// The 16 colours of the standard palette, blue first.
const PALETTE: [[u8; 3]; 16] = [
    [0x00, 0x00, 0x00],
    [0x00, 0x00, 0x80],
    [0x00, 0x80, 0x00],
    [0x00, 0x80, 0x80],
    [0x80, 0x00, 0x00],
    [0x80, 0x00, 0x80],
    [0x80, 0x80, 0x00],
    [0x80, 0x80, 0x80],
    [0xC0, 0xC0, 0xC0],
    [0x00, 0x00, 0xFF],
    [0x00, 0xFF, 0x00],
    [0x00, 0xFF, 0xFF],
    [0xFF, 0x00, 0x00],
    [0xFF, 0x00, 0xFF],
    [0xFF, 0xFF, 0x00],
    [0xFF, 0xFF, 0xFF],
];

/// A colour: its index in the palette.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Colour(u8);

const BLACK: Colour = Colour(0);
const GREEN: Colour = Colour(2);
const DARK_GREY: Colour = Colour(7);
const GREY: Colour = Colour(8);
const RED: Colour = Colour(9);
const YELLOW: Colour = Colour(11);
const BLUE: Colour = Colour(12);
const WHITE: Colour = Colour(15);

/// What a bitmap of a device shows.
///
/// ```
/// use profivac_client::gsd::Bitmap;
/// use profivac_devices::catalog::model_named;
///
/// let model = model_named("bcg450").ok_or("no such model")?;
/// assert_eq!(Bitmap::Device.name(model), "BCG450_N");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bitmap {
    /// The device (`Bitmap_Device`).
    Device,
    /// The device has a diagnosis (`Bitmap_Diag`).
    Diagnosis,
    /// A special mode of operation (`Bitmap_SF`).
    Special,
}

impl Bitmap {
    /// All bitmaps of a device, in the order of the GSD file.
    pub const ALL: [Self; 3] = [Self::Device, Self::Diagnosis, Self::Special];

    /// Where the model of a GSD file has its name.
    pub(super) const fn field(self, general: &mut General) -> &mut Option<String> {
        match self {
            Self::Device => &mut general.bitmap_device,
            Self::Diagnosis => &mut general.bitmap_diag,
            Self::Special => &mut general.bitmap_sf,
        }
    }

    /// The name of the file without its extension, at most eight characters: `BCG450_N`.
    #[must_use]
    pub fn name(self, model: &Model) -> String {
        let letter = match self {
            Self::Device => 'N',
            Self::Diagnosis => 'D',
            Self::Special => 'S',
        };
        format!("{}_{letter}", model.name.to_uppercase())
    }

    /// The file.
    ///
    /// ```
    /// use profivac_client::gsd::Bitmap;
    /// use profivac_devices::catalog::model_named;
    ///
    /// let file = Bitmap::Device.file(model_named("bcg450").ok_or("no such model")?);
    /// assert!(file.starts_with(b"BM") && file.len() == 1558);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn file(self, model: &Model) -> Vec<u8> {
        let mut picture = Picture::new();
        if is_controller(model) {
            picture.controller()
        } else {
            picture.gauge()
        }
        picture.name(&model.name.to_uppercase());
        match self {
            Self::Device => {}
            Self::Diagnosis => picture.mark(RED, &EXCLAMATION_MARK),
            Self::Special => picture.mark(BLUE, &LETTER_S),
        }
        picture.file()
    }
}

/// A device with the values of several channels is a controller.
fn is_controller(model: &Model) -> bool {
    let mut inputs = model.configurations.iter().filter_map(|one| one.inputs);
    inputs.any(|telegram| telegram.fields.iter().any(|field| matches!(field, Field::ChannelValue(..))))
}

/// Rows of points; a character is five rows of three.
type Glyph = [u8; 5];

const EXCLAMATION_MARK: Glyph = [0b010, 0b010, 0b010, 0b000, 0b010];
const LETTER_S: Glyph = [0b111, 0b100, 0b111, 0b001, 0b111];

/// The characters of the device names.
const fn glyph(character: char) -> Glyph {
    match character {
        '0' => [0b111, 0b101, 0b101, 0b101, 0b111],
        '2' => [0b111, 0b001, 0b111, 0b100, 0b111],
        '3' => [0b111, 0b001, 0b111, 0b001, 0b111],
        '4' => [0b101, 0b101, 0b111, 0b001, 0b001],
        '5' | 'S' => LETTER_S,
        'B' => [0b110, 0b101, 0b110, 0b101, 0b110],
        'C' => [0b111, 0b100, 0b100, 0b100, 0b111],
        'G' => [0b111, 0b100, 0b101, 0b101, 0b111],
        'H' => [0b101, 0b101, 0b111, 0b101, 0b101],
        'I' => [0b111, 0b010, 0b010, 0b010, 0b111],
        'M' => [0b101, 0b111, 0b111, 0b101, 0b101],
        'P' => [0b111, 0b101, 0b111, 0b100, 0b100],
        'T' => [0b111, 0b010, 0b010, 0b010, 0b010],
        _ => [0b111; 5],
    }
}

struct Picture {
    rows: [[Colour; WIDTH]; HEIGHT],
}

impl Picture {
    const fn new() -> Self {
        Self { rows: [[WHITE; WIDTH]; HEIGHT] }
    }

    /// Fills a rectangle.
    fn fill(&mut self, (left, top): (usize, usize), (width, height): (usize, usize), colour: Colour) {
        for row in self.rows.iter_mut().skip(top).take(height) {
            for point in row.iter_mut().skip(left).take(width) {
                *point = colour;
            }
        }
    }

    /// A rectangle with an edge of one point.
    fn framed(&mut self, (left, top): (usize, usize), (width, height): (usize, usize), colour: Colour) {
        self.fill((left, top), (width, height), BLACK);
        let inner = (width.saturating_sub(2), height.saturating_sub(2));
        self.fill((left.saturating_add(1), top.saturating_add(1)), inner, colour);
    }

    /// A gauge: its housing with a connector above, and the flange below.
    fn gauge(&mut self) {
        self.framed((29, 1), (12, 5), DARK_GREY);
        self.framed((8, 5), (54, 22), GREY);
        self.fill((9, 22), (52, 2), GREEN);
        self.framed((27, 26), (16, 8), WHITE);
        self.framed((20, 33), (30, 5), DARK_GREY);
    }

    /// A controller: its front with a display, and a key for each channel.
    fn controller(&mut self) {
        self.framed((3, 4), (64, 32), GREY);
        self.framed((6, 7), (58, 15), WHITE);
        for channel in 0..4 {
            self.framed((10_usize.saturating_add(14_usize.saturating_mul(channel)), 26), (8, 6), GREEN);
        }
    }

    /// The name of the device in its middle, with points of two by two.
    fn name(&mut self, name: &str) {
        const ADVANCE: usize = 8;
        let width = name.chars().count().saturating_mul(ADVANCE).saturating_sub(2);
        let mut left = WIDTH.saturating_sub(width) / 2;
        for character in name.chars() {
            self.glyph((left, 10), &glyph(character), BLACK);
            left = left.saturating_add(ADVANCE);
        }
    }

    fn glyph(&mut self, (left, top): (usize, usize), glyph: &Glyph, colour: Colour) {
        for (row, bits) in glyph.iter().enumerate() {
            for (column, mask) in [0b100, 0b010, 0b001].into_iter().enumerate() {
                if bits & mask != 0 {
                    let corner =
                        (left.saturating_add(column.saturating_mul(2)), top.saturating_add(row.saturating_mul(2)));
                    self.fill(corner, (2, 2), colour);
                }
            }
        }
    }

    /// A mark in the lower right corner.
    fn mark(&mut self, colour: Colour, glyph: &Glyph) {
        self.framed((54, 24), (16, 16), colour);
        self.glyph((59, 27), glyph, if colour == RED { YELLOW } else { WHITE });
    }

    /// The file: headers, colours, and the rows from below.
    fn file(&self) -> Vec<u8> {
        let pixels = u32::try_from(ROW * HEIGHT).unwrap_or_default();
        let start = FILE_HEADER + INFO_HEADER + COLOUR_TABLE;
        let mut file = Vec::from(*b"BM");
        file.extend(start.saturating_add(pixels).to_le_bytes());
        file.extend([0; 4]);
        file.extend(start.to_le_bytes());
        let side = |points: usize| u32::try_from(points).unwrap_or_default().to_le_bytes();
        file.extend([INFO_HEADER.to_le_bytes(), side(WIDTH), side(HEIGHT)].concat());
        // One plane, four bits a point, not compressed.
        file.extend([1, 0, 4, 0, 0, 0, 0, 0]);
        file.extend(pixels.to_le_bytes());
        // The resolution is open; all 16 colours are used.
        file.extend([[0; 4], [0; 4], 16_u32.to_le_bytes(), [0; 4]].concat());
        for [red_last, green, first] in PALETTE.map(|[blue, green, red]| [red, green, blue]) {
            file.extend([first, green, red_last, 0]);
        }
        for row in self.rows.iter().rev() {
            let octets = row.chunks(2).map(|pair| match pair {
                [left, right] => left.0 << 4 | right.0,
                [left] => left.0 << 4,
                _ => 0,
            });
            let padding = ROW.saturating_sub(WIDTH.div_ceil(2));
            file.extend(octets.chain(std::iter::repeat_n(0, padding)));
        }
        file
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_devices::catalog::MODELS;
    use std::collections::BTreeSet;

    /// A reader of the format: width, height, bits, and the colour of each point from the upper left.
    fn read(file: &[u8]) -> (u32, u32, u16, Vec<[u8; 3]>) {
        let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap());
        assert_eq!((&file[..2], word(2) as usize, word(14), word(30)), (&b"BM"[..], file.len(), 40, 0));
        let (width, height, start) = (word(18), word(22), word(10) as usize);
        let (columns, rows) = (width as usize, height as usize);
        let stride = (columns * 4).div_ceil(32) * 4;
        assert_eq!(start + stride * rows, file.len());
        let mut points = Vec::new();
        for row in (0..rows).rev() {
            for column in 0..columns {
                let octet = file[start + row * stride + column / 2];
                let colour = 54 + 4 * usize::from(if column % 2 == 0 { octet >> 4 } else { octet & 0x0F });
                points.push([file[colour + 2], file[colour + 1], file[colour]]);
            }
        }
        (width, height, u16::from_le_bytes([file[28], file[29]]), points)
    }

    #[test]
    fn every_bitmap_has_the_size_of_the_specification_and_differs_from_the_others() {
        let mut pictures = BTreeSet::new();
        let mut names = BTreeSet::new();
        for model in MODELS {
            for bitmap in Bitmap::ALL {
                let (width, height, bits, points) = read(&bitmap.file(model));
                assert_eq!((width, height, bits, points.len()), (70, 40, 4, 2800), "{}", model.name);
                assert!(pictures.insert(points), "{} {bitmap:?}", model.name);
                let name = bitmap.name(model);
                assert!(name.len() <= 8 && names.insert(name.clone()), "{name}");
            }
        }
        assert_eq!(pictures.len(), 36);
    }

    #[test]
    fn a_diagnosis_has_a_red_mark_and_a_special_mode_a_blue_one() {
        let model = MODELS[0];
        let corner = |bitmap: Bitmap| read(&bitmap.file(model)).3[38 * 70 + 68];
        assert_eq!(corner(Bitmap::Device), [0xFF; 3]);
        assert_eq!((corner(Bitmap::Diagnosis), corner(Bitmap::Special)), ([0xFF, 0, 0], [0, 0, 0xFF]));
    }

    #[test]
    fn every_character_of_a_device_name_has_a_glyph() {
        for character in MODELS.iter().flat_map(|model| model.name.to_uppercase().chars().collect::<Vec<_>>()) {
            assert_ne!(glyph(character), [0b111; 5], "{character}");
        }
    }
}
