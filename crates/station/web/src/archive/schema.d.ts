// Generated from archive-openapi.json by `npm run generate`. Do not edit.

export interface paths {
    "/api/archive": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Stations, latest readings, active alarms */
        get: operations["archive"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/events": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Events, the latest first */
        get: operations["get_events"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/live": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * The same, and its changes, up to one a second
         * @description Server-sent events. The event `snapshot` has the whole state and comes first; each event `change` has the parts of it that have
         *     changed: of stations, readings and alarms the entries that have changed, `null` for one that is gone. The stream ends with the session of its client.
         */
        get: operations["live"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/point-trend": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * The trend of a point, in its unit
         * @description Values where a pixel is shorter than two minutes, otherwise the spans of the station.
         */
        get: operations["get_point_trend"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/points": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The points of slaves, with their units */
        get: operations["get_points"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/stations/{station}/alarms/{alarm}/acknowledge": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Acknowledge an alarm at its station
         * @description The station decides, and writes the name of the user into its audit trail. The changed state comes in the live stream.
         */
        post: operations["acknowledge"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/trend": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * The trend of a series
         * @description Samples where a pixel is shorter than two minutes, otherwise the spans of the station. A series without rows has an empty trend.
         */
        get: operations["get_trend"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
}
export type webhooks = Record<string, never>;
export interface components {
    schemas: {
        /** @description The occurrence of an alarm that a user has seen. */
        Acknowledge: {
            /**
             * Format: int64
             * @description The number of the occurrence.
             * @example 1
             */
            occurrence: number;
        };
        /** @description An alarm that is not normal. */
        ActiveAlarm: {
            /** @description The name of the alarm. */
            alarm: string;
            /**
             * Format: int64
             * @description When the state began, in milliseconds since 1970.
             */
            at_ms: number;
            /**
             * Format: int64
             * @description The number of the occurrence, which an acknowledgement names.
             */
            occurrence: number;
            /** @description The plant. */
            plant: string;
            /** @description The priority. */
            priority: components["schemas"]["Priority"];
            /** @description The state, which is not `normal`. */
            state: components["schemas"]["AlarmState"];
            /** @description The station. */
            station: string;
            /** @description The gauge or the segment that the alarm is about. */
            subject?: string | null;
            /** @description What happened, in a sentence. */
            text: string;
            /** @description The user who brought it into this state. */
            user?: string | null;
        };
        /**
         * @description The state of an alarm.
         * @enum {string}
         */
        AlarmState: "normal" | "unacknowledged" | "acknowledged" | "returned" | "shelved" | "out-of-service" | "suppressed";
        /** @description Something that happened at a station. */
        ArchivedEvent: components["schemas"]["Event"] & {
            /** @description The plant. */
            plant: string;
            /** @description The station. */
            station: string;
        };
        /** @description A point of a station of the archive. */
        ArchivedPoint: {
            /** @description The plant. */
            plant: string;
            /** @description The point, with its unit. */
            point: components["schemas"]["RecordedPoint"];
            /** @description The station. */
            station: string;
        };
        /** @description The text of a code or of a bit. */
        CodeText: {
            /**
             * Format: double
             * @description The number that is recorded for it.
             */
            number: number;
            /** @description The text of the station's file; `off` or `on` of a bit without one. */
            text: string;
        };
        /** @description Something that happened. */
        Event: {
            /**
             * Format: int64
             * @description When, in milliseconds since 1970.
             */
            at_ms: number;
            /** @description The gauge, if the event is about one. */
            gauge?: string | null;
            /** @description The kind. */
            kind: components["schemas"]["StationEventKind"];
            /** @description One sentence. */
            text: string;
        };
        /** @description The latest reading of a series. */
        LatestReading: {
            /**
             * Format: int64
             * @description When it was measured, or when the time of a mean began, in milliseconds since 1970.
             */
            at_ms: number;
            /**
             * Format: double
             * @description The end of the range that the pressure is beyond, in Pa.
             */
            limit_pa?: number | null;
            /**
             * Format: int64
             * @description The milliseconds from `at_ms` on of which `pa` is the geometric mean; `null` for a sample.
             */
            mean_of_ms?: number | null;
            /**
             * Format: double
             * @description The pressure in Pa; `null` unless the reading is valid.
             */
            pa?: number | null;
            /** @description The quality. */
            quality: components["schemas"]["Quality"];
            /** @description The series: the name of a gauge, or `gauge.N` for channel N of a controller. */
            series: string;
            /** @description The station. */
            station: string;
        };
        /**
         * @description What the values of a point of a slave are.
         * @enum {string}
         */
        PointKind: "number" | "code";
        /** @description The trend of a point, in its unit: each list has one entry for every pixel with values. */
        PointTrend: {
            /** @description The highest number. */
            high: (number | null)[];
            /** @description The number that was recorded last in the pixel. */
            last: (number | null)[];
            /** @description The lowest number; `null` without a number. */
            low: (number | null)[];
            /** @description The arithmetic mean; always `null` for a code or a bit. */
            mean: (number | null)[];
            /** @description The point, with its unit. */
            point: components["schemas"]["RecordedPoint"];
            /** @description The qualities that occurred: bit 0 valid, 3 fault, 4 stale. */
            qualities: number[];
            /** @description The start of each pixel, in milliseconds since 1970, rising. */
            start_ms: number[];
            /** @description The texts of its codes in the station's file; empty for a number. */
            texts: components["schemas"]["CodeText"][];
        };
        /**
         * @description How soon an operator must respond. Ordered: `High` is the greatest.
         * @enum {string}
         */
        Priority: "low" | "medium" | "high";
        /** @description A problem document after RFC 9457: why a request was refused. Its `type` is `about:blank`, so it is left out. */
        Problem: {
            /**
             * @description The reason in a sentence: what was expected and what was found.
             * @example there is no gauge "chamber"
             */
            detail: string;
            /**
             * Format: int32
             * @description The HTTP status.
             * @example 404
             */
            status: number;
            /**
             * @description The phrase for the HTTP status.
             * @example Not Found
             */
            title: string;
        };
        /**
         * @description The state of a reading: whether it is a pressure, and if not, why.
         * @enum {string}
         */
        Quality: "valid" | "overrange" | "underrange" | "fault" | "stale" | "off" | "missing" | "assumed";
        /** @description A point whose values are recorded. With another unit, or as another kind, it is another point: numbers in two units are never mixed. */
        RecordedPoint: {
            /** @description What the values are. */
            kind: components["schemas"]["PointKind"];
            /** @description The name of the point, unique for its slave. */
            name: string;
            /** @description The slave. */
            slave: string;
            /** @description The unit of the values; `null` without one. */
            unit?: string | null;
        };
        /** @description The state of all stations at one moment. */
        State: {
            /** @description Alarms that are not normal, by station and alarm: `hall-1/chamber limit`. */
            alarms: {
                [key: string]: components["schemas"]["ActiveAlarm"];
            };
            /**
             * Format: int64
             * @description The number of such alarms beyond the list.
             */
            not_listed: number;
            /**
             * Format: int64
             * @description The time of the archive, in milliseconds since 1970.
             */
            now_ms: number;
            /** @description Why the rest is old: the database does not answer. */
            problem?: string | null;
            /** @description The latest reading of each series, by station and series: `hall-1/chamber`. */
            readings: {
                [key: string]: components["schemas"]["LatestReading"];
            };
            /** @description The stations, by name. */
            stations: {
                [key: string]: components["schemas"]["StationState"];
            };
        };
        /**
         * @description The subject of an event.
         * @enum {string}
         */
        StationEventKind: "station" | "bus" | "gauge" | "command" | "note" | "access" | "alarm" | "pump-down";
        /** @description A station as the archive knows it. */
        StationState: {
            /**
             * Format: int64
             * @description When it made its last batch by its own clock, in milliseconds since 1970; `null` before the first one.
             */
            made_ms?: number | null;
            /**
             * Format: int64
             * @description Batches that have not come.
             */
            missing: number;
            /** @description Its plant. */
            plant: string;
            /**
             * Format: int64
             * @description Batches that were put aside.
             */
            put_aside: number;
            /** @description Why the last one of them was put aside, in a sentence. */
            put_aside_reason?: string | null;
            /**
             * Format: int64
             * @description When the archive stored its last batch, in milliseconds since 1970.
             */
            stored_ms?: number | null;
        };
        /** @description A trend: each list has one entry for every pixel with samples. */
        Trend: {
            /** @description The highest pressure in Pa. Where the gauge was above its range, the end of the range. */
            high: (number | null)[];
            /**
             * @description The pressure in Pa that was recorded last in the pixel, which the gauge held until the next pixel of the list; `null` if the pixel
             *     ends without a measured pressure, and where only summaries are stored.
             */
            last: (number | null)[];
            /** @description The lowest pressure in Pa; `null` without a pressure. Where the gauge was below its range, the end of the range. */
            low: (number | null)[];
            /** @description The geometric mean of the measured pressures in Pa; `null` without one. The end of a range is in no mean. */
            mean: (number | null)[];
            /**
             * @description The qualities that occurred: bit 0 valid, 1 overrange, 2 underrange, 3 fault, 4 stale, 5 off, 6
             *     missing, 7 assumed.
             */
            qualities: number[];
            /** @description The name of the series. */
            series: string;
            /** @description The start of each pixel, in milliseconds since 1970, rising. */
            start_ms: number[];
        };
    };
    responses: never;
    parameters: never;
    requestBodies: never;
    headers: never;
    pathItems: never;
}
export type $defs = Record<string, never>;
export interface operations {
    archive: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["State"];
                };
            };
        };
    };
    get_events: {
        parameters: {
            query: {
                /**
                 * @description The station; all unless given.
                 * @example hall-1
                 */
                station?: string;
                /**
                 * @description The beginning, in milliseconds since 1970.
                 * @example 0
                 */
                from: number;
                /**
                 * @description The end, in milliseconds since 1970.
                 * @example 4102444800000
                 */
                to: number;
                /** @description The most events of the answer, 1 to 10000. */
                limit?: number;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ArchivedEvent"][];
                };
            };
            /** @description A parameter is wrong */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The database does not answer */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    live: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "text/event-stream": components["schemas"]["State"];
                };
            };
        };
    };
    get_point_trend: {
        parameters: {
            query: {
                /**
                 * @description The station.
                 * @example hall-1
                 */
                station: string;
                /**
                 * @description The slave.
                 * @example turbo
                 */
                slave: string;
                /**
                 * @description The point.
                 * @example speed
                 */
                point: string;
                /** @description The unit, if the point was recorded in several; empty for a point without a unit. Default: the unit of the last value. */
                unit?: string;
                /**
                 * @description The beginning, in milliseconds since 1970.
                 * @example 0
                 */
                from: number;
                /**
                 * @description The end, in milliseconds since 1970.
                 * @example 4102444800000
                 */
                to: number;
                /** @description The most entries of the trend, 1 to 20000. */
                pixels?: number;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["PointTrend"];
                };
            };
            /** @description A parameter is wrong */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The archive has no such station or point */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The database does not answer */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_points: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ArchivedPoint"][];
                };
            };
            /** @description The database does not answer */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    acknowledge: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /**
                 * @description The station
                 * @example hall-1
                 */
                station: string;
                /**
                 * @description The alarm
                 * @example chamber too high
                 */
                alarm: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Acknowledge"];
            };
        };
        responses: {
            /** @description The alarm is acknowledged */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description The body is malformed */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role operator is needed */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The archive has no such station */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The station refuses */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The file of the archive has no way to the station */
            501: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The station does not answer */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_trend: {
        parameters: {
            query: {
                /**
                 * @description Station and series: `hall-1/chamber`.
                 * @example hall-1/chamber
                 */
                series: string;
                /**
                 * @description The beginning, in milliseconds since 1970.
                 * @example 0
                 */
                from: number;
                /**
                 * @description The end, in milliseconds since 1970.
                 * @example 4102444800000
                 */
                to: number;
                /** @description The most entries of the trend, 1 to 20000. */
                pixels?: number;
                /** @description Whether the station is asked for the trend of its own database, which has all samples; then `pixels` is 4000 at most. */
                full?: boolean;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Trend"];
                };
            };
            /** @description A parameter is wrong */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The archive has no such station */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The station refuses */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The file of the archive has no way to the station */
            501: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The database or the station does not answer */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
}
