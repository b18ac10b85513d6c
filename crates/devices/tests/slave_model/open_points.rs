//! The points that `docs/spec` leaves open. The model answers there as the slave does; `open(N)` in its code names the row.
//! The second list has the values and refusals of parameters that the model takes from the device, with the reason.

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
    (
        16,
        "profibus-wire 4.6.3",
        "an address of type 1 below 8 octets, and a type above 1, is answered with Abort 00 12",
    ),
    (17, "profibus-wire 4.6.5", "an Initiate to another network is bound for the Send_Timeout that it asks for"),
    (18, "profibus-wire 3.2", "an exchange that begins again is no command to the device"),
];

/// What the model takes from the device, from number 1 on. `B` is errata-bpg-bcg-tpg, `P` is errata-pxg55x-img400.
pub const OF_THE_DEVICE: &[&str] = &[
    "of the device: time has not passed for sensors, emission and memory",
    "of the device: a value as delivered that no manual gives (B 73, P 85, P 102)",
    "of the device: whether a negative or enormous pressure is stored (B 74)",
    "of the device: a command in INIT and SELFTESTING, and Recover in IDLE (B 89, P 25)",
    "of the device: the number outside the range of an instance, or the last one (B 76, B 81)",
    "of the device: the emission after a command (B 102, P 149)",
    "of the device: command 0 with a value (B 93)",
    "of the device: its number, versions, hours, and the ambient pressure (B 36, B 37, P 59)",
    "of the device: the part that measured last, and the emission current (B 78, B 97, B 98)",
    "of the device: relays and the status of channels (B 106, B 141, P 97, P 127)",
    "of the device: a hysteresis in COUNTS (P 32)",
    "of the device: readings after an adjustment, and with the Pirani off (P 78, P 107)",
    "of the device: the ranges of the gauges, which another manual has (P 133)",
    "of the device: a factor without a range (P 99)",
    "of the device: which of two errors of an adjustment comes first (P 131)",
    "of the device: whether a refused degas is a warning (B 96)",
    "of the device: a hysteresis below the digits of its trip point",
];
