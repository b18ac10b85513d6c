-- Version 4: points of slaves, with their units. The tables of pressures stay as they are.

-- A point of a slave. unit: that of its values, empty without one. kind: number; code, also of a bit. With another unit or kind it is another row.
CREATE TABLE profivac_data.point (
    id      integer GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    station integer NOT NULL REFERENCES profivac_data.station,
    slave   text    NOT NULL,
    name    text    NOT NULL,
    unit    text    NOT NULL,
    kind    text    NOT NULL,
    UNIQUE (station, slave, name, unit, kind)
);

CREATE TABLE profivac_data.point_sample (
    point   integer     NOT NULL,
    at      timestamptz NOT NULL,
    value   double precision,
    quality smallint    NOT NULL,
    PRIMARY KEY (point, at)
) PARTITION BY RANGE (at);

-- The summaries of the station, as in profivac_data.span.
CREATE TABLE profivac_data.point_span (
    point      integer     NOT NULL,
    level      smallint    NOT NULL,
    start      timestamptz NOT NULL,
    epoch      bigint      NOT NULL,
    batch      bigint      NOT NULL,
    min_value  double precision,
    max_value  double precision,
    last_value double precision,
    sum        double precision NOT NULL,
    count      bigint      NOT NULL,
    qualities  smallint    NOT NULL,
    PRIMARY KEY (point, level, start, epoch)
);

-- Makes the partitions of a day (UTC), of pressures and of points; see version 3.
CREATE OR REPLACE FUNCTION profivac_data.add_day(day date) RETURNS void LANGUAGE plpgsql AS $$
DECLARE
    parent text;
    name   text;
BEGIN
    PERFORM pg_advisory_xact_lock(1885763171);
    FOREACH parent IN ARRAY ARRAY['sample', 'point_sample'] LOOP
        name := parent || '_' || to_char(day, 'YYYYMMDD');
        IF to_regclass('profivac_data.' || name) IS NULL THEN
            EXECUTE format('CREATE TABLE profivac_data.%I (LIKE profivac_data.%I INCLUDING ALL)', name, parent);
            EXECUTE format('ALTER TABLE profivac_data.%I ATTACH PARTITION profivac_data.%I FOR VALUES FROM (%L) TO (%L)',
                parent, name, day::text || ' 00:00:00+00', (day + 1)::text || ' 00:00:00+00');
        END IF;
    END LOOP;
END $$;

-- Drops the partitions of the days before this one, of pressures and of points; see version 3.
CREATE OR REPLACE FUNCTION profivac_data.drop_days(before date) RETURNS integer LANGUAGE plpgsql SET lock_timeout = '1s' AS $$
DECLARE
    name    text;
    dropped integer := 0;
BEGIN
    PERFORM pg_advisory_xact_lock(1885763171);
    FOR name IN
        SELECT relname FROM pg_inherits JOIN pg_class ON pg_class.oid = inhrelid
        WHERE (inhparent = 'profivac_data.sample'::regclass AND relname < 'sample_' || to_char(before, 'YYYYMMDD'))
            OR (inhparent = 'profivac_data.point_sample'::regclass AND relname < 'point_sample_' || to_char(before, 'YYYYMMDD'))
    LOOP
        EXECUTE format('DROP TABLE profivac_data.%I', name);
        -- A day has a partition of pressures; it may have one of points.
        IF name LIKE 'sample_%' THEN
            dropped := dropped + 1;
        END IF;
    END LOOP;
    RETURN dropped;
EXCEPTION WHEN lock_not_available THEN
    RETURN 0;
END $$;

CREATE VIEW profivac.point WITH (security_barrier) AS
    SELECT point.id AS point_id, plant, station.name AS station, point.slave, point.name AS point, point.unit, point.kind
    FROM profivac_data.point JOIN profivac_data.readable AS station ON station.id = point.station;

-- value is in the unit of the point.
CREATE VIEW profivac.point_sample WITH (security_barrier) AS
    SELECT p.plant, p.station, p.slave, p.point, p.unit, p.kind, p.point_id, sample.at, sample.value, sample.quality
    FROM profivac.point p JOIN profivac_data.point_sample AS sample ON sample.point = p.point_id;

-- mean_value is the arithmetic mean; a code or a bit has none. last_value: the one that was recorded last.
CREATE VIEW profivac.point_span WITH (security_barrier) AS
    SELECT p.plant, p.station, p.slave, p.point, p.unit, p.kind, p.point_id, span.level, span.start,
        min(span.min_value) AS min_value, max(span.max_value) AS max_value,
        CASE WHEN p.kind = 'number' AND sum(span.count) > 0 THEN sum(span.sum) / sum(span.count) END AS mean_value,
        (array_agg(span.last_value ORDER BY span.epoch DESC) FILTER (WHERE span.last_value IS NOT NULL))[1] AS last_value,
        sum(span.count)::bigint AS count, bit_or(span.qualities) AS qualities
    FROM profivac.point p JOIN profivac_data.point_span AS span ON span.point = p.point_id
    GROUP BY p.plant, p.station, p.slave, p.point, p.unit, p.kind, p.point_id, span.level, span.start;
