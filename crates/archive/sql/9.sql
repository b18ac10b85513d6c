-- Version 9: a sample takes less room. The columns are in an order without gaps, and the key belongs to the table of a day, so that a day
-- that is over can do without it: see `store/packing.rs`.

ALTER TABLE profivac_data.sample RENAME TO sample_8;
ALTER TABLE profivac_data.point_sample RENAME TO point_sample_8;

-- Each day has the key (series, at), until it is packed.
CREATE TABLE profivac_data.sample (
    at          timestamptz NOT NULL,
    pressure_pa double precision,
    series      integer     NOT NULL,
    quality     smallint    NOT NULL
) PARTITION BY RANGE (at);

-- Each day has the key (point, at), until it is packed.
CREATE TABLE profivac_data.point_sample (
    at      timestamptz NOT NULL,
    value   double precision,
    point   integer     NOT NULL,
    quality smallint    NOT NULL
) PARTITION BY RANGE (at);

-- The days move as they are, with their keys. PostgreSQL reads each of them once. The empty ones are made again by `add_day`.
DO $$
DECLARE
    it       record;
    is_empty boolean;
BEGIN
    FOR it IN
        SELECT parent.relname AS parent, child.relname AS name, pg_get_expr(child.relpartbound, child.oid) AS bound
        FROM pg_inherits JOIN pg_class AS child ON child.oid = inhrelid JOIN pg_class AS parent ON parent.oid = inhparent
        WHERE inhparent IN ('profivac_data.sample_8'::regclass, 'profivac_data.point_sample_8'::regclass)
        ORDER BY child.relname
    LOOP
        EXECUTE format('ALTER TABLE profivac_data.%I DETACH PARTITION profivac_data.%I', it.parent, it.name);
        EXECUTE format('SELECT NOT EXISTS (SELECT FROM profivac_data.%I)', it.name) INTO is_empty;
        IF is_empty AND it.name ~ '^(point_)?sample_[0-9]{8}$' THEN
            EXECUTE format('DROP TABLE profivac_data.%I', it.name);
        ELSE
            EXECUTE format('ALTER TABLE profivac_data.%I ATTACH PARTITION profivac_data.%I %s', replace(it.parent, '_8', ''), it.name, it.bound);
        END IF;
    END LOOP;
END $$;

CREATE OR REPLACE VIEW profivac.sample WITH (security_barrier) AS
    SELECT s.plant, s.station, s.series, s.series_id, sample.at, sample.pressure_pa, sample.quality
    FROM profivac.series s JOIN profivac_data.sample ON sample.series = s.series_id;

CREATE OR REPLACE VIEW profivac.point_sample WITH (security_barrier) AS
    SELECT p.plant, p.station, p.slave, p.point, p.unit, p.kind, p.point_id, sample.at, sample.value, sample.quality, known.text
    FROM profivac.point p JOIN profivac_data.point_sample AS sample ON sample.point = p.point_id
    LEFT JOIN profivac_data.point_text AS known ON known.point = sample.point AND known.value = sample.value;

DROP TABLE profivac_data.sample_8, profivac_data.point_sample_8;

-- Makes the tables of a day (UTC), of pressures and of points, with their keys; see version 3.
CREATE OR REPLACE FUNCTION profivac_data.add_day(day date) RETURNS void LANGUAGE plpgsql AS $$
DECLARE
    parent text;
    name   text;
BEGIN
    PERFORM pg_advisory_xact_lock(1885763171);
    FOREACH parent IN ARRAY ARRAY['sample', 'point_sample'] LOOP
        name := parent || '_' || to_char(day, 'YYYYMMDD');
        IF to_regclass('profivac_data.' || name) IS NULL THEN
            EXECUTE format('CREATE TABLE profivac_data.%I (LIKE profivac_data.%I INCLUDING ALL, PRIMARY KEY (%I, at))',
                name, parent, CASE parent WHEN 'sample' THEN 'series' ELSE 'point' END);
            EXECUTE format('ALTER TABLE profivac_data.%I ATTACH PARTITION profivac_data.%I FOR VALUES FROM (%L) TO (%L)',
                parent, name, day::text || ' 00:00:00+00', (day + 1)::text || ' 00:00:00+00');
        END IF;
    END LOOP;
END $$;

-- An archive of an older program that still runs would rely on the keys. It sees by the file of this table that the tables are others, reads
-- their version, and ends its work.
CLUSTER profivac_data.series USING series_pkey;
ALTER TABLE profivac_data.series SET WITHOUT CLUSTER;
