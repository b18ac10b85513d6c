//! The points that `docs/spec` leaves open. The model answers there as the slave does; `open(N)` in its code names the row.

/// Number, section of the specification, and the behaviour.
pub const OPEN: &[(u8, &str, &str)] = &[
    (1, "profibus-wire 2.4", "the answer to a Set_Prm still comes after the old min T_SDR"),
    (2, "profibus-wire 4.6.5", "an Initiate to another API or SCL than 0 is refused with D7 80 B8 00"),
    (
        3,
        "profibus-wire 3.3",
        "Global_Control that sets Not_Supported announces it each time; Sync and Freeze announce nothing",
    ),
    (4, "profibus-wire 3.3", "an event or static diagnosis from before Data_Exch is announced in its first exchange"),
    (5, "profibus-wire 4.6.5", "an Initiate that Abort answers is bound for the slave's own Send_Timeout"),
    (6, "profibus-wire 2.11", "a new station address closes all MS2 connections"),
    (7, "profibus-wire 2.9", "octets behind the second one of Global_Control are ignored"),
    (8, "profibus-wire 4.6.3", "an Initiate without DPV1_RW is refused with D7 80 A9 00"),
    (9, "profibus-wire 3.2", "another accepted configuration in Data_Exch begins the exchange again"),
    (10, "profibus-wire 5.1", "a refused Write to index 255 forgets the Call before it"),
    (11, "profibus-wire 1.3", "SSAP 63 is answered with RS"),
    (12, "profibus-wire 1.11", "the gauges answer Ident with RS"),
    (13, "profibus-wire 4.3", "an unknown function on MS1 gets SC before the slave leaves its master"),
    (14, "profibus-wire 4.1.3", "a valid Data_Transport is refused with D1 80 A9 00"),
    (15, "profibus-wire 2.4", "Set_Prm of another master is ignored before its length is checked"),
];
