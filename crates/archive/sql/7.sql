-- Version 7: the end of a range is in no mean of a span, also of a station of version 0.1, which counts it where no pressure is valid (bit 0).

CREATE OR REPLACE VIEW profivac.span WITH (security_barrier) AS
    SELECT s.plant, s.station, s.series, s.series_id, span.level, span.start,
        min(span.min_pa) AS min_pa, max(span.max_pa) AS max_pa,
        10 ^ (sum(span.log10_sum) FILTER (WHERE span.qualities & 1 = 1)
            / nullif(sum(span.count) FILTER (WHERE span.qualities & 1 = 1), 0)) AS mean_pa,
        sum(span.count)::bigint AS count, bit_or(span.qualities) AS qualities
    FROM profivac.series s JOIN profivac_data.span ON span.series = s.series_id
    GROUP BY s.plant, s.station, s.series, s.series_id, span.level, span.start;
