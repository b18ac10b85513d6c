//! The parameters of a slave for a master.

/// A slave as a master sees it.
#[derive(Clone, Debug)]
pub struct Slave {
    /// Its station address.
    pub address: u8,
    /// Ident_Number.
    pub ident: u16,
    /// The octets of Chk_Cfg.
    pub cfg: Vec<u8>,
    /// User_Prm_Data.
    pub user_prm: Vec<u8>,
    /// Octets from master to slave.
    pub outputs: usize,
    /// Octets from slave to master.
    pub inputs: usize,
}
