//! What an operator does about batches that were put aside: chooses the database of a station, and stores the batches again.

use super::{Incoming, Store, StoreError, Stored};
use profivac_recorder::Micros;

/// The batches that are read at once.
const PAGE: i64 = 256;

const OTHER: &str = "
    SELECT rejected.epoch FROM profivac_data.rejected JOIN profivac_data.station ON station.name = rejected.station
    WHERE station.name = $1 AND rejected.competes AND rejected.epoch <> station.epoch ORDER BY rejected.id DESC LIMIT 1";

/// The latest change of each alarm, of the databases that are not refused.
const ALARMS: &str = "
    INSERT INTO profivac_data.alarm_state
        (station, alarm, epoch, id, at, change, state, priority, subject, occurrence, user_name, value, unit, text)
    SELECT DISTINCT ON (alarm)
        station, alarm, epoch, id, at, change, state, priority, subject, occurrence, user_name, value, unit, text
    FROM profivac_data.alarm
    WHERE station = $1 AND epoch NOT IN (SELECT epoch FROM profivac_data.epoch WHERE epoch.station = $1 AND refused)
    ORDER BY alarm, epoch DESC, id DESC";

impl Store {
    /// Chooses the database whose batches of this station were put aside last as the one of the station, and refuses later ones. Returns when
    /// it began; `None` if no batches of another database are put aside.
    ///
    /// # Errors
    /// [`StoreError`] when the database refuses; nothing is changed then.
    pub async fn accept_other(&mut self, station: &str) -> Result<Option<Micros>, StoreError> {
        let transaction = self.client.transaction().await?;
        let Some(row) = transaction.query_opt(OTHER, &[&station]).await? else { return Ok(None) };
        let epoch: i64 = row.get(0);
        let sql = "UPDATE profivac_data.station SET epoch = $2 WHERE name = $1 RETURNING id";
        let id: i32 = transaction.query_one(sql, &[&station, &epoch]).await?.get(0);
        let refuse = "UPDATE profivac_data.epoch SET refused = epoch > $2 WHERE station = $1";
        transaction.execute(refuse, &[&id, &epoch]).await?;
        transaction.execute("DELETE FROM profivac_data.alarm_state WHERE station = $1", &[&id]).await?;
        transaction.execute(ALARMS, &[&id]).await?;
        transaction.commit().await?;
        Ok(Some(Micros(epoch)))
    }

    /// Stores the batches that were put aside, those whose reason is over. The others stay.
    ///
    /// # Errors
    /// [`StoreError`] when the database refuses.
    pub async fn store_again(&mut self, now: Micros) -> Result<Stored, StoreError> {
        let (mut sum, mut last) = (Stored::default(), 0_i64);
        loop {
            let sql = "SELECT id, subject, message_id, payload, station FROM profivac_data.rejected WHERE id > $1 ORDER BY id LIMIT $2";
            let rows = self.client.query(sql, &[&last, &PAGE]).await?;
            let Some(end) = rows.last() else { return Ok(sum) };
            last = end.get("id");
            for row in &rows {
                let message =
                    Incoming { subject: row.get("subject"), id: row.get("message_id"), payload: row.get("payload") };
                let stored = self.store(std::slice::from_ref(&message), now).await?;
                if stored.rejected == 0 {
                    self.forget_rejected(row.get("id"), row.get("station")).await?;
                }
                sum.add(stored);
            }
        }
    }

    async fn forget_rejected(&mut self, id: i64, station: Option<String>) -> Result<(), StoreError> {
        let transaction = self.client.transaction().await?;
        transaction.execute("DELETE FROM profivac_data.rejected WHERE id = $1", &[&id]).await?;
        let count = "UPDATE profivac_data.put_aside SET count = greatest(count - 1, 0) WHERE station = $1";
        transaction.execute(count, &[&station]).await?;
        Ok(transaction.commit().await?)
    }
}
