//! Rows that a database of a station and a copy of it have both: one of them stays. Either may come first.

/// Deletes, of the spans of one time that a database and its copy have sent, those with fewer samples: the views add the spans of the
/// databases of a station, and the one that ran longer has more of the time around the copy. `span` is the table, `of` what the spans are of.
pub fn poorer_spans(span: &str, of: &str) -> String {
    format!(
        "DELETE FROM profivac_data.{span} AS poorer
            USING stage_{span} AS staged, profivac_data.{of} AS owner, profivac_data.epoch, profivac_data.{span} AS fuller
            WHERE owner.id = staged.{of} AND epoch.station = owner.station AND epoch.is_copy
                AND epoch.epoch = greatest(poorer.epoch, fuller.epoch)
                AND poorer.{of} = staged.{of} AND poorer.level = staged.level AND poorer.start = staged.start
                AND fuller.{of} = staged.{of} AND fuller.level = staged.level AND fuller.start = staged.start
                AND poorer.epoch <> fuller.epoch AND (poorer.count, poorer.epoch) < (fuller.count, fuller.epoch)"
    )
}

/// Deletes the rows of an event, an alarm or an audit entry that a copy has sent again: the same id and the same time are the same row. Rows
/// of the time after the copy have other times and stay.
pub fn earlier_rows(table: &str) -> String {
    format!(
        "DELETE FROM profivac_data.{table} AS earlier
            USING stage_{table} AS staged, profivac_data.epoch, profivac_data.{table} AS copy
            WHERE copy.station = staged.station AND copy.id = staged.id AND copy.at = staged.at
                AND epoch.station = copy.station AND epoch.epoch = copy.epoch AND epoch.is_copy
                AND earlier.station = staged.station AND earlier.id = staged.id AND earlier.at = staged.at
                AND earlier.epoch < copy.epoch"
    )
}
