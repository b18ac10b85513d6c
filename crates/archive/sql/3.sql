-- Version 3: partitions without waiting for readers, and a limit for the alarms of a station.

-- Makes the partition of a day (UTC). A table that is attached does not wait for those who read the others: a dump of the database and an
-- open transaction of a reader may take hours. The lock keeps two archives from making the same one.
CREATE OR REPLACE FUNCTION profivac_data.add_day(day date) RETURNS void LANGUAGE plpgsql AS $$
DECLARE
    name text := 'sample_' || to_char(day, 'YYYYMMDD');
BEGIN
    PERFORM pg_advisory_xact_lock(1885763171);
    IF to_regclass('profivac_data.' || name) IS NULL THEN
        EXECUTE format('CREATE TABLE profivac_data.%I (LIKE profivac_data.sample INCLUDING ALL)', name);
        EXECUTE format('ALTER TABLE profivac_data.sample ATTACH PARTITION profivac_data.%I FOR VALUES FROM (%L) TO (%L)',
            name, day::text || ' 00:00:00+00', (day + 1)::text || ' 00:00:00+00');
    END IF;
END $$;

-- Drops the partitions of the days before this one. Those that a reader holds stay until the next call: while a session waits for the lock on
-- all samples, all others wait behind it.
CREATE OR REPLACE FUNCTION profivac_data.drop_days(before date) RETURNS integer LANGUAGE plpgsql SET lock_timeout = '1s' AS $$
DECLARE
    name    text;
    dropped integer := 0;
BEGIN
    PERFORM pg_advisory_xact_lock(1885763171);
    FOR name IN
        SELECT relname FROM pg_inherits JOIN pg_class ON pg_class.oid = inhrelid
        WHERE inhparent = 'profivac_data.sample'::regclass AND relname < 'sample_' || to_char(before, 'YYYYMMDD')
    LOOP
        EXECUTE format('DROP TABLE profivac_data.%I', name);
        dropped := dropped + 1;
    END LOOP;
    RETURN dropped;
EXCEPTION WHEN lock_not_available THEN
    RETURN 0;
END $$;

-- A station that invents names of alarms must not fill the list of all stations. 10,000 as for its series; free choice.
CREATE FUNCTION profivac_data.limit_alarms() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE
    full_station integer;
BEGIN
    SELECT station INTO full_station FROM (SELECT DISTINCT station FROM added) AS changed
        WHERE (SELECT count(*) FROM profivac_data.alarm_state WHERE alarm_state.station = changed.station) > 10000 LIMIT 1;
    IF FOUND THEN
        RAISE check_violation USING MESSAGE =
            'the station has more than 10000 alarms: delete in profivac_data.alarm_state those that it no longer has';
    END IF;
    RETURN NULL;
END $$;

-- Triggers run in the order of their names: after keep_latest.
CREATE TRIGGER limit_alarms AFTER INSERT ON profivac_data.alarm
    REFERENCING NEW TABLE AS added FOR EACH STATEMENT EXECUTE FUNCTION profivac_data.limit_alarms();

-- The events of one station, the latest first.
CREATE INDEX event_of_station ON profivac_data.event (station, at);
