-- Version 6: a role that sees no row is told why.

-- Says why the views have no rows for a role, once in a query; always false. Called where a station is not readable.
CREATE FUNCTION profivac_data.explain_no_rows(reading name) RETURNS boolean LANGUAGE plpgsql STABLE SECURITY DEFINER
    SET search_path = pg_catalog AS $$
DECLARE
    plants text;
BEGIN
    SELECT string_agg(DISTINCT reader.plant, ', ') INTO plants FROM profivac_data.reader JOIN pg_roles ON rolname = reader.role
        WHERE pg_has_role(reading, pg_roles.oid, 'member');
    IF plants IS NULL THEN
        RAISE NOTICE 'the views of profivac have no rows for role %: it is a reader of no plant', reading
            USING HINT = 'Add it to readers of a [[plant]] in the file of the archive and start the archive again, or GRANT it a role that is there.';
    ELSIF NOT EXISTS (SELECT FROM profivac_data.station WHERE station.plant = ANY (string_to_array(plants, ', '))) THEN
        RAISE NOTICE 'the views of profivac have no rows for role %: no station sends with the plant that it reads, %', reading, plants
            USING HINT = 'Compare name of [[plant]] in the file of the archive with plant of [archive] in the files of the stations.';
    END IF;
    RETURN false;
END $$;

-- The stations that the present user may read, see version 1. The last condition is a subquery of its own, so that a query asks once.
CREATE OR REPLACE VIEW profivac_data.readable WITH (security_barrier) AS
    SELECT id, plant, name, epoch FROM profivac_data.station
    WHERE pg_has_role(current_user, (SELECT relowner FROM pg_class WHERE oid = 'profivac_data.station'::regclass), 'member')
        OR EXISTS (
            SELECT FROM profivac_data.reader JOIN pg_roles ON rolname = reader.role
            WHERE reader.plant = station.plant AND pg_has_role(current_user, pg_roles.oid, 'member'))
        OR (SELECT profivac_data.explain_no_rows(current_user::name));
