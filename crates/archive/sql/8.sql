-- Version 8: the texts of the codes of points.

-- The text that the file of the station has for a value of a point that is a code or a bit; of a value that is no longer in the file, the last one.
CREATE TABLE profivac_data.point_text (
    point integer          NOT NULL,
    value double precision NOT NULL,
    text  text             NOT NULL,
    epoch bigint           NOT NULL,
    batch bigint           NOT NULL,
    PRIMARY KEY (point, value)
);

CREATE VIEW profivac.point_text WITH (security_barrier) AS
    SELECT p.plant, p.station, p.slave, p.point, p.unit, p.kind, p.point_id, known.value, known.text
    FROM profivac.point p JOIN profivac_data.point_text AS known ON known.point = p.point_id;

-- text is that of the value; NULL without one.
CREATE OR REPLACE VIEW profivac.point_sample WITH (security_barrier) AS
    SELECT p.plant, p.station, p.slave, p.point, p.unit, p.kind, p.point_id, sample.at, sample.value, sample.quality, known.text
    FROM profivac.point p JOIN profivac_data.point_sample AS sample ON sample.point = p.point_id
    LEFT JOIN profivac_data.point_text AS known ON known.point = sample.point AND known.value = sample.value;
