//! What a device is, as tables: ident number, services, configurations, user parameters.

/// A configuration and the lengths of its data.
#[derive(Clone, Debug)]
pub struct Configuration {
    pub octets: Vec<u8>,
    pub outputs: usize,
    pub inputs: usize,
}

/// The table of a device.
#[derive(Clone, Debug)]
pub struct Table {
    pub name: String,
    pub ident: u16,
    pub sync: bool,
    pub freeze: bool,
    pub dpv1: bool,
    pub ms1: bool,
    pub ms2: bool,
    pub address_settable: bool,
    pub configurations: Vec<Configuration>,
    pub default_configuration: usize,
    /// Strings of user parameters.
    pub user_parameters: Vec<Vec<u8>>,
    /// Bits that the first two octets of them may have besides.
    pub free_bits: [u8; 2],
    pub ident_strings: Option<[String; 4]>,
    pub im0: Option<[u8; 64]>,
}

impl Table {
    /// The simple device, which supports every service.
    pub fn simple() -> Self {
        let cfg = |octets: &[u8], outputs, inputs| Configuration { octets: octets.to_vec(), outputs, inputs };
        let mut im0 = [0x20; 64];
        im0[10..12].copy_from_slice(&[1, 0x23]);
        Self {
            name: "simple".into(),
            ident: 0x1234,
            sync: true,
            freeze: true,
            dpv1: true,
            ms1: true,
            ms2: true,
            address_settable: true,
            configurations: vec![
                cfg(&[0x11, 0x21], 2, 2),
                cfg(&[0x13, 0x20], 1, 4),
                cfg(&[0x22], 3, 0),
                cfg(&[0x12], 0, 3),
                cfg(&[0x42, 0x84, 8, 5], 0, 5),
                cfg(&[0x27, 0x17], 8, 8),
            ],
            default_configuration: 0,
            user_parameters: vec![vec![], vec![0, 0, 0], vec![0, 0, 0, 0x11, 0x22]],
            free_bits: [0xC4, 0x01],
            ident_strings: Some(["vendor", "chip", "1", "2.0"].map(String::from)),
            im0: Some(im0),
        }
    }

    /// Whether the user parameters are one of the strings.
    pub fn takes_user_parameters(&self, user: &[u8]) -> bool {
        let mut plain = user.to_vec();
        for (octet, free) in plain.iter_mut().zip(self.free_bits) {
            *octet &= !free;
        }
        self.user_parameters.contains(&plain)
    }
}
