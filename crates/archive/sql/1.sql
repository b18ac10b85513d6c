-- Version 1 of the tables of an archive. Times have a zone, pressures are in Pa and end in _pa, as in the database of a station.

CREATE TABLE profivac_data.station (
    id    integer GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    plant text    NOT NULL,
    name  text    NOT NULL UNIQUE,
    -- The newest database of the station, by the microsecond at which it began.
    epoch bigint  NOT NULL
);

CREATE TABLE profivac_data.series (
    id      integer GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    station integer NOT NULL REFERENCES profivac_data.station,
    name    text    NOT NULL,
    UNIQUE (station, name)
);

-- The batches of the last days. A batch that comes again changes nothing.
CREATE TABLE profivac_data.batch (
    station integer     NOT NULL REFERENCES profivac_data.station,
    epoch   bigint      NOT NULL,
    number  bigint      NOT NULL,
    made    timestamptz NOT NULL,
    stored  timestamptz NOT NULL DEFAULT clock_timestamp(),
    samples integer     NOT NULL,
    -- Samples that were older than the retention when they came.
    expired integer     NOT NULL,
    PRIMARY KEY (station, epoch, number)
);
CREATE INDEX batch_stored ON profivac_data.batch USING brin (stored);

CREATE TABLE profivac_data.sample (
    series      integer     NOT NULL,
    at          timestamptz NOT NULL,
    pressure_pa double precision,
    quality     smallint    NOT NULL,
    PRIMARY KEY (series, at)
) PARTITION BY RANGE (at);

-- The summaries of the station, never added to here. A later batch of the same database replaces a span.
CREATE TABLE profivac_data.span (
    series    integer     NOT NULL,
    level     smallint    NOT NULL,
    start     timestamptz NOT NULL,
    epoch     bigint      NOT NULL,
    batch     bigint      NOT NULL,
    min_pa    double precision,
    max_pa    double precision,
    log10_sum double precision NOT NULL,
    count     bigint      NOT NULL,
    qualities smallint    NOT NULL,
    PRIMARY KEY (series, level, start, epoch)
);

CREATE TABLE profivac_data.event (
    station integer     NOT NULL REFERENCES profivac_data.station,
    epoch   bigint      NOT NULL,
    id      bigint      NOT NULL,
    at      timestamptz NOT NULL,
    series  text,
    kind    text        NOT NULL,
    text    text        NOT NULL,
    PRIMARY KEY (station, epoch, id)
);
CREATE INDEX event_at ON profivac_data.event (at);

CREATE TABLE profivac_data.alarm (
    station    integer     NOT NULL REFERENCES profivac_data.station,
    epoch      bigint      NOT NULL,
    id         bigint      NOT NULL,
    at         timestamptz NOT NULL,
    alarm      text        NOT NULL,
    change     text        NOT NULL,
    state      text        NOT NULL,
    priority   text        NOT NULL,
    subject    text,
    occurrence bigint      NOT NULL,
    user_name  text,
    value      double precision,
    unit       text,
    text       text        NOT NULL,
    PRIMARY KEY (station, epoch, id)
);
CREATE INDEX alarm_at ON profivac_data.alarm (at);

CREATE TABLE profivac_data.audit (
    station   integer     NOT NULL REFERENCES profivac_data.station,
    epoch     bigint      NOT NULL,
    id        bigint      NOT NULL,
    at        timestamptz NOT NULL,
    action    text        NOT NULL,
    refers_to bigint,
    user_name text        NOT NULL,
    role      text        NOT NULL,
    peer      text,
    gauge     text,
    target    text,
    before    text,
    after     text,
    outcome   text,
    PRIMARY KEY (station, epoch, id)
);
CREATE INDEX audit_at ON profivac_data.audit (at);

-- Batches that were not stored, whole, with the reason.
CREATE TABLE profivac_data.rejected (
    id         bigint      GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    at         timestamptz NOT NULL DEFAULT clock_timestamp(),
    subject    text        NOT NULL,
    message_id text        NOT NULL,
    reason     text        NOT NULL,
    payload    bytea       NOT NULL
);
CREATE UNIQUE INDEX rejected_once ON profivac_data.rejected (subject, message_id, md5(payload));

-- The roles that may read the stations of a plant.
CREATE TABLE profivac_data.reader (
    plant text NOT NULL,
    role  text NOT NULL,
    PRIMARY KEY (plant, role)
);

-- Makes the partition of a day (UTC). The lock keeps two archives from making the same one.
CREATE FUNCTION profivac_data.add_day(day date) RETURNS void LANGUAGE plpgsql AS $$
DECLARE
    name text := 'sample_' || to_char(day, 'YYYYMMDD');
BEGIN
    PERFORM pg_advisory_xact_lock(1885763171);
    IF to_regclass('profivac_data.' || name) IS NULL THEN
        EXECUTE format('CREATE TABLE profivac_data.%I PARTITION OF profivac_data.sample FOR VALUES FROM (%L) TO (%L)',
            name, day::text || ' 00:00:00+00', (day + 1)::text || ' 00:00:00+00');
    END IF;
END $$;

-- Drops the partitions of the days before this one.
CREATE FUNCTION profivac_data.drop_days(before date) RETURNS integer LANGUAGE plpgsql AS $$
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
END $$;

CREATE SCHEMA profivac;

-- The stations that the present user may read: as a member of a role of the plant, or of the owner of the tables.
CREATE VIEW profivac_data.readable WITH (security_barrier) AS
    SELECT id, plant, name, epoch FROM profivac_data.station
    WHERE pg_has_role(current_user, (SELECT relowner FROM pg_class WHERE oid = 'profivac_data.station'::regclass), 'member')
        OR EXISTS (
            SELECT FROM profivac_data.reader JOIN pg_roles ON rolname = reader.role
            WHERE reader.plant = station.plant AND pg_has_role(current_user, pg_roles.oid, 'member'));

CREATE FUNCTION profivac.quality_word(quality smallint) RETURNS text LANGUAGE sql IMMUTABLE AS $$
    SELECT (ARRAY['valid', 'overrange', 'underrange', 'fault', 'stale', 'off', 'missing', 'assumed'])[quality + 1]
$$;

CREATE VIEW profivac.series WITH (security_barrier) AS
    SELECT series.id AS series_id, plant, station.name AS station, series.name AS series
    FROM profivac_data.series JOIN profivac_data.readable AS station ON station.id = series.station;

CREATE VIEW profivac.sample WITH (security_barrier) AS
    SELECT s.plant, s.station, s.series, s.series_id, sample.at, sample.pressure_pa, sample.quality
    FROM profivac.series s JOIN profivac_data.sample ON sample.series = s.series_id;

-- level: 2 of two minutes, 3 of half an hour, 4 of six hours. mean_pa is the geometric mean.
CREATE VIEW profivac.span WITH (security_barrier) AS
    SELECT s.plant, s.station, s.series, s.series_id, span.level, span.start,
        min(span.min_pa) AS min_pa, max(span.max_pa) AS max_pa,
        CASE WHEN sum(span.count) > 0 THEN 10 ^ (sum(span.log10_sum) / sum(span.count)) END AS mean_pa,
        sum(span.count)::bigint AS count, bit_or(span.qualities) AS qualities
    FROM profivac.series s JOIN profivac_data.span ON span.series = s.series_id
    GROUP BY s.plant, s.station, s.series, s.series_id, span.level, span.start;

CREATE VIEW profivac.event WITH (security_barrier) AS
    SELECT plant, station.name AS station, event.at, event.series, event.kind, event.text, event.epoch, event.id
    FROM profivac_data.event JOIN profivac_data.readable AS station ON station.id = event.station;

CREATE VIEW profivac.alarm WITH (security_barrier) AS
    SELECT plant, station.name AS station, alarm.at, alarm.alarm, alarm.change, alarm.state, alarm.priority, alarm.subject,
        alarm.occurrence, alarm.user_name, alarm.value, alarm.unit, alarm.text, alarm.epoch, alarm.id
    FROM profivac_data.alarm JOIN profivac_data.readable AS station ON station.id = alarm.station;

CREATE VIEW profivac.audit WITH (security_barrier) AS
    SELECT plant, station.name AS station, audit.at, audit.action, audit.refers_to, audit.user_name, audit.role, audit.peer,
        audit.gauge, audit.target, audit.before, audit.after, audit.outcome, audit.epoch, audit.id
    FROM profivac_data.audit JOIN profivac_data.readable AS station ON station.id = audit.station;

-- missing: numbers between the first and the last batch of the present database that have not come (yet).
CREATE VIEW profivac.station WITH (security_barrier) AS
    SELECT plant, name AS station, epoch, last_batch, made AS last_made, stored AS last_stored, stored - made AS delay, missing
    FROM profivac_data.readable AS station
    LEFT JOIN LATERAL (
        SELECT max(number) AS last_batch, max(number) - min(number) + 1 - count(*) AS missing, max(made) AS made, max(stored) AS stored
        FROM profivac_data.batch WHERE batch.station = station.id AND batch.epoch = station.epoch
    ) AS batches ON true;
