-- Version 2: the latest change of each alarm, so that a list of the active ones reads no history.

CREATE TABLE profivac_data.alarm_state (
    station    integer     NOT NULL REFERENCES profivac_data.station,
    alarm      text        NOT NULL,
    epoch      bigint      NOT NULL,
    id         bigint      NOT NULL,
    at         timestamptz NOT NULL,
    change     text        NOT NULL,
    state      text        NOT NULL,
    priority   text        NOT NULL,
    subject    text,
    occurrence bigint      NOT NULL,
    user_name  text,
    value      double precision,
    unit       text,
    text       text        NOT NULL,
    PRIMARY KEY (station, alarm)
);

-- Rows that come late or again change nothing.
CREATE FUNCTION profivac_data.keep_latest_alarm() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    INSERT INTO profivac_data.alarm_state (station, alarm, epoch, id, at, change, state, priority, subject, occurrence, user_name, value, unit, text)
        SELECT DISTINCT ON (station, alarm)
            station, alarm, epoch, id, at, change, state, priority, subject, occurrence, user_name, value, unit, text
        FROM added ORDER BY station, alarm, epoch DESC, id DESC
    ON CONFLICT (station, alarm) DO UPDATE SET
        epoch = excluded.epoch, id = excluded.id, at = excluded.at, change = excluded.change, state = excluded.state,
        priority = excluded.priority, subject = excluded.subject, occurrence = excluded.occurrence, user_name = excluded.user_name,
        value = excluded.value, unit = excluded.unit, text = excluded.text
    WHERE (alarm_state.epoch, alarm_state.id) < (excluded.epoch, excluded.id);
    RETURN NULL;
END $$;

CREATE TRIGGER keep_latest AFTER INSERT ON profivac_data.alarm
    REFERENCING NEW TABLE AS added FOR EACH STATEMENT EXECUTE FUNCTION profivac_data.keep_latest_alarm();

INSERT INTO profivac_data.alarm_state (station, alarm, epoch, id, at, change, state, priority, subject, occurrence, user_name, value, unit, text)
    SELECT DISTINCT ON (station, alarm)
        station, alarm, epoch, id, at, change, state, priority, subject, occurrence, user_name, value, unit, text
    FROM profivac_data.alarm ORDER BY station, alarm, epoch DESC, id DESC;

-- Alarms of the present database of each station that are not normal, without those that were removed from the station's file.
CREATE VIEW profivac.active_alarm WITH (security_barrier) AS
    SELECT plant, station.name AS station, alarm.alarm, alarm.state, alarm.priority, alarm.occurrence, alarm.subject, alarm.at, alarm.change, alarm.user_name,
        alarm.value, alarm.unit, alarm.text
    FROM profivac_data.alarm_state AS alarm JOIN profivac_data.readable AS station ON station.id = alarm.station AND station.epoch = alarm.epoch
    WHERE alarm.state <> 'normal' AND alarm.change <> 'removed';
