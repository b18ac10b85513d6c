-- Version 5: the numbers of batches that have not come, and what was put aside, for each station.
-- The databases of a station. Each number up to `settled`, from the first batch of the database on, is stored, put aside, or in `gap`.
CREATE TABLE profivac_data.epoch (
    station integer NOT NULL REFERENCES profivac_data.station,
    epoch   bigint  NOT NULL,
    settled bigint  NOT NULL,
    -- The first number that two copies of the database have given to a batch.
    copied  bigint,
    -- The database began as a copy of an earlier one: it goes on with the numbers of that, and may send rows that are stored.
    is_copy boolean NOT NULL DEFAULT false,
    -- An operator has chosen an earlier database as the one of the station.
    refused boolean NOT NULL DEFAULT false,
    PRIMARY KEY (station, epoch)
);

-- An older program did not say which number is the first one.
INSERT INTO profivac_data.epoch (station, epoch, settled) SELECT station, epoch, min(number) - 1 FROM profivac_data.batch GROUP BY station, epoch;

-- Numbers that have not come. The archives ask the station for them again and again.
CREATE TABLE profivac_data.gap (
    station integer     NOT NULL REFERENCES profivac_data.station,
    epoch   bigint      NOT NULL,
    first   bigint      NOT NULL,
    last    bigint      NOT NULL,
    found   timestamptz NOT NULL DEFAULT clock_timestamp(),
    PRIMARY KEY (station, epoch, first)
);

-- When the stations were told last what the database has of them: one archive does so for all.
CREATE TABLE profivac_data.told (
    at timestamptz NOT NULL
);
INSERT INTO profivac_data.told VALUES ('-infinity');

-- The station and the number of a batch that was put aside, if its subject and its id name them.
ALTER TABLE profivac_data.rejected ADD COLUMN station text, ADD COLUMN epoch bigint, ADD COLUMN number bigint,
    -- It is of another database under the name of the station, which an operator can choose.
    ADD COLUMN competes boolean NOT NULL DEFAULT false;
UPDATE profivac_data.rejected SET station = split_part(subject, '.', 4) WHERE subject ~ '^profivac\.v1\.[^.]+\.[^.]+\.batch$';
UPDATE profivac_data.rejected SET epoch = split_part(message_id, '/', 2)::bigint, number = split_part(message_id, '/', 3)::bigint
    WHERE station IS NOT NULL AND message_id ~ '^[^/]+/[0-9]{1,18}/[0-9]{1,18}$';
CREATE INDEX rejected_of_station ON profivac_data.rejected (station, epoch, number);

-- What was put aside of each station, also what was deleted since.
CREATE TABLE profivac_data.put_aside (
    station text        PRIMARY KEY,
    count   bigint      NOT NULL,
    at      timestamptz NOT NULL,
    reason  text        NOT NULL
);
INSERT INTO profivac_data.put_aside (station, count, at, reason)
    SELECT station, count(*), max(at), (array_agg(reason ORDER BY id DESC))[1] FROM profivac_data.rejected WHERE station IS NOT NULL GROUP BY station;

-- Notes the gaps. A batch that comes up to 40 s after a later one is on its way: JetStream hands a batch out again after 30 s if the archive
-- that had it was killed.
CREATE FUNCTION profivac_data.find_gaps() RETURNS void LANGUAGE plpgsql AS $$
DECLARE
    waited timestamptz := clock_timestamp() - interval '40 s';
    it     record;
BEGIN
    -- Another archive may search.
    IF NOT pg_try_advisory_xact_lock(1885763172) THEN
        RETURN;
    END IF;
    -- What is left of a gap in which batches have come.
    FOR it IN
        SELECT gap.*, station.name FROM profivac_data.gap JOIN profivac_data.station ON station.id = gap.station
        WHERE EXISTS (SELECT FROM profivac_data.batch
                WHERE batch.station = gap.station AND batch.epoch = gap.epoch AND batch.number BETWEEN gap.first AND gap.last)
            OR EXISTS (SELECT FROM profivac_data.rejected
                WHERE rejected.station = station.name AND rejected.epoch = gap.epoch AND rejected.number BETWEEN gap.first AND gap.last)
    LOOP
        DELETE FROM profivac_data.gap WHERE gap.station = it.station AND gap.epoch = it.epoch AND gap.first = it.first;
        INSERT INTO profivac_data.gap (station, epoch, first, last, found)
            SELECT it.station, it.epoch, steps.before + 1, steps.number - 1, it.found
            FROM (
                SELECT came.number, lag(came.number, 1, it.first - 1) OVER (ORDER BY came.number) AS before
                FROM (
                    SELECT batch.number FROM profivac_data.batch
                        WHERE batch.station = it.station AND batch.epoch = it.epoch AND batch.number BETWEEN it.first AND it.last
                    UNION ALL
                    SELECT rejected.number FROM profivac_data.rejected
                        WHERE rejected.station = it.name AND rejected.epoch = it.epoch AND rejected.number BETWEEN it.first AND it.last
                    UNION ALL SELECT it.last + 1
                ) AS came
            ) AS steps
            WHERE steps.number > steps.before + 1;
    END LOOP;
    -- New gaps. One statement, so that no batch comes between the search and the note how far it went.
    WITH arrived AS (
        SELECT epoch.station, epoch.epoch, epoch.settled, came.number, came.at
        FROM profivac_data.epoch JOIN profivac_data.station ON station.id = epoch.station
        CROSS JOIN LATERAL (
            SELECT batch.number, batch.stored AS at FROM profivac_data.batch
                WHERE batch.station = epoch.station AND batch.epoch = epoch.epoch AND batch.number > epoch.settled
            UNION ALL
            SELECT rejected.number, rejected.at FROM profivac_data.rejected
                WHERE rejected.station = station.name AND rejected.epoch = epoch.epoch AND rejected.number > epoch.settled
        ) AS came
    ), steps AS MATERIALIZED (
        SELECT arrived.station, arrived.epoch, arrived.number,
            lag(arrived.number, 1, arrived.settled) OVER (PARTITION BY arrived.station, arrived.epoch ORDER BY arrived.number) AS before,
            max(arrived.number) FILTER (WHERE arrived.at < waited) OVER (PARTITION BY arrived.station, arrived.epoch) AS until
        FROM arrived
    ), noted AS (
        INSERT INTO profivac_data.gap (station, epoch, first, last)
            SELECT steps.station, steps.epoch, steps.before + 1, steps.number - 1 FROM steps
            WHERE steps.number <= steps.until AND steps.number > steps.before + 1
    )
    UPDATE profivac_data.epoch SET settled = ends.until
        FROM (SELECT DISTINCT steps.station, steps.epoch, steps.until FROM steps WHERE steps.until IS NOT NULL) AS ends
        WHERE ends.station = epoch.station AND ends.epoch = epoch.epoch;
END $$;

-- missing: numbers from the first batch on that have not come, of all databases of the station. put_aside: batches that came and were not
-- stored, with the last reason.
CREATE OR REPLACE VIEW profivac.station WITH (security_barrier) AS
    SELECT plant, name AS station, epoch, last_batch, made AS last_made, stored AS last_stored, stored - made AS delay,
        (SELECT least(coalesce(sum(gap.last - gap.first + 1), 0), 9223372036854775807)::bigint
            FROM profivac_data.gap WHERE gap.station = station.id) AS missing,
        coalesce(put_aside.count, 0) AS put_aside, put_aside.at AS last_put_aside, put_aside.reason AS put_aside_reason
    FROM profivac_data.readable AS station
    LEFT JOIN LATERAL (
        SELECT number AS last_batch, made, stored FROM profivac_data.batch
        WHERE batch.station = station.id AND batch.epoch = station.epoch ORDER BY number DESC LIMIT 1
    ) AS last ON true
    LEFT JOIN profivac_data.put_aside ON put_aside.station = station.name;

-- The gaps in what is stored already: with many batches this takes longer than a statement of a running archive may.
SELECT profivac_data.find_gaps();
