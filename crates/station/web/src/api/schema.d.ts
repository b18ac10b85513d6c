// Generated from openapi.json by `npm run generate`. Do not edit.

export interface paths {
    "/api/alarms": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** All alarms: those of the configuration file in its order, then the default alarms */
        get: operations["alarms"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/alarms/acknowledge": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Acknowledge several alarms
         * @description Each alarm is acknowledged or refused on its own.
         */
        post: operations["acknowledge_all"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/alarms/history": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The history of alarms, the latest change first */
        get: operations["history"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/alarms/performance": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Figures of the alarms: how many, how often, which
         * @description After ISA-18.2, clause 16. The time range is at most 366 days long.
         */
        get: operations["performance"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/alarms/shelve": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Shelve alarms for a while
         * @description A shelved alarm is silent; at its end it is raised at once if its condition holds. Each alarm is shelved or refused on its own.
         */
        post: operations["shelve"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/alarms/unshelve": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Unshelve alarms
         * @description An alarm whose condition holds is raised at once. Each alarm is unshelved or refused on its own.
         */
        post: operations["unshelve"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/alarms/{name}/acknowledge": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Acknowledge an alarm
         * @description Acknowledges the occurrence that the user has seen, and no later one. The database has the change before the answer.
         */
        post: operations["acknowledge"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/alarms/{name}/out-of-service": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Take an alarm out of service, with a reason, for a time or without an end */
        post: operations["out_of_service"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/alarms/{name}/return-to-service": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Return an alarm to service
         * @description If its condition holds, the alarm is raised at once.
         */
        post: operations["return_to_service"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/alarms/{name}/settings": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The settings of an alarm, as the station's file writes them */
        get: operations["settings"];
        put?: never;
        /**
         * Change the settings of an alarm
         * @description The station's file and the running alarm have the change before the answer; the state of the alarm stays.
         */
        post: operations["change"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/armed-commands/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        post?: never;
        /** Disarm an armed command */
        delete: operations["disarm"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/armed-commands/{id}/execute": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Execute an armed command
         * @description The second step. The station checks the conditions and the present value again, and sends the command once. The
         *     user needs control authority.
         */
        post: operations["execute"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/audit": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The audit trail, the latest entry first */
        get: operations["audit"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/audit.csv": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The audit trail as CSV, the earliest entry first; times are ISO 8601 in UTC */
        get: operations["csv"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/backup": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Make a copy of the database
         * @description The copy is one state of the database: samples, events, alarms and the audit trail. It is checked before the answer. The audit trail
         *     has the user. At most one copy exists: a copy that is not being downloaded ends with the next one.
         */
        post: operations["backup"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/backup/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Download a copy of the database
         * @description The copy is one SQLite file that `profivac report`, `export` and a station open.
         */
        get: operations["download"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/control-authority": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The user with control authority */
        get: operations["authority"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/control-authority/grant": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Grant control authority to the user who requested it */
        post: operations["grant"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/control-authority/release": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Release control authority */
        post: operations["release"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/control-authority/request": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Request control authority
         * @description If control authority is free, the user gets it. Otherwise the holder sees the request.
         */
        post: operations["request"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/control-authority/take-over": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Take over control authority from its holder
         * @description An engineer may do so at any time, an operator 60 s after a request without an answer.
         */
        post: operations["take_over"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/default-alarms": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The settings of all default alarms, as the table `[alarms]` of the station's file writes them; empty if the station has no file */
        get: operations["defaults"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/default-alarms/{name}/settings": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Change the settings of a default alarm
         * @description The station's file and the running alarms have the change before the answer; the alarms that are still there keep their states.
         */
        post: operations["change_default"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/directory": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * The directory: the labels of the gauges, and the views
         * @description Groups, tags, locations and calibrations; filters of the overview and groups of trends. It changes with the station's file. The live
         *     stream has a new `directory_revision` when this answer changes.
         */
        get: operations["directory"];
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
        /** The events of a time range, the latest first */
        get: operations["events"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/export.csv": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The samples of a time range as CSV: time (ISO 8601, UTC), series, pressure in Pa, quality */
        get: operations["export"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/export.parquet": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * The samples of a time range as a Parquet file: time (UTC), series, pressure in Pa, quality
         * @description A program that is built without the feature `parquet` answers 501.
         */
        get: operations["export_parquet"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/gateways": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The gateways to control systems, with their clients and errors */
        get: operations["gateways"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/gauges": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** All gauges with their readings */
        get: operations["gauges"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/gauges/{name}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** One gauge with its readings */
        get: operations["gauge"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/gauges/{name}/arm": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Arm a command or a write
         * @description The first step. The station reads the conditions and the present value from the gauge. If all conditions are met, the command
         *     is armed for 30 seconds. The user needs control authority.
         */
        post: operations["arm"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/gauges/{name}/blocks": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * The blocks and parameters of a gauge
         * @description The station reads the parameters from the gauge now, beside its cyclic data.
         */
        get: operations["blocks"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/gauges/{name}/commands": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * The commands of a gauge with their conditions and risks
         * @description The station answers from its tables, without a request to the gauge.
         */
        get: operations["commands"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/identify": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * The numbers of a plant from the samples of one pump-down, base pressure and rise, with 95 % intervals
         * @description The station fits one plant at a time, and stops when the client disconnects or after two minutes.
         */
        get: operations["identify"];
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
         * The state of the station and its changes, up to four a second
         * @description Server-sent events. The event `snapshot` has the whole state and comes first; each event `change` has the parts of it that have
         *     changed. A slow client gets fewer events, and misses no change. The stream is compressed for a client that accepts gzip. It ends with
         *     the session of its client.
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
    "/api/login": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Begin a session
         * @description A wrong password and an unknown name get the same answer after the same time.
         */
        post: operations["login"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/logout": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * End the session
         * @description A user of an OpenID provider may still have a session there: the browser ends it at the address of the answer.
         */
        post: operations["logout"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/notes": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Make a note
         * @description The note is an event of the kind `note` with the name of the user. The database has it before the answer.
         */
        post: operations["make"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/openid/begin": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Begin a login at the OpenID provider
         * @description The answer sets a cookie that binds the login to the browser, which continues at the address.
         */
        post: operations["openid_begin"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/openid/login": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Complete a login at the OpenID provider, and begin a session */
        post: operations["openid_login"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/password": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Change the password of the user
         * @description All sessions of the user end, and the answer begins a new one.
         */
        post: operations["password"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/plant": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * The plant: its volumes, and the valves and pumps between them
         * @description It changes with the station's file. The states of the parts are in the live stream, which has a new `plant.revision` when this answer
         *     changes.
         */
        get: operations["plant"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/plant-states": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** All plant states of the station's file, with their declarations */
        get: operations["plant_states"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/plant-states/{name}/declare": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Declare a plant state for a time
         * @description Its alarms are suppressed at once; at its end those whose conditions hold are raised. The database has the change before the answer.
         */
        post: operations["declare"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/plant-states/{name}/end": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * End a declared plant state
         * @description The alarms whose conditions hold are raised at once. Every operator ends every plant state.
         */
        post: operations["end"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/plant-states/{name}/extend": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Give a declared plant state a later end
         * @description The user who declared it stays; the reason is the new one.
         */
        post: operations["extend"];
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
        /** The trend of a point in its unit: minimum, maximum, mean and last value of each pixel */
        get: operations["point_trend"];
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
        /** The points of slaves whose values were recorded, with their units, and the texts of codes in the station's file */
        get: operations["points"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/points.csv": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The values of points of a time range as CSV: time (ISO 8601, UTC), slave, point, unit, value, quality, text of a code */
        get: operations["export_points"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/points.parquet": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * The values of points of a time range as a Parquet file: time (UTC), slave, point, unit, value, quality, text of a code
         * @description A program that is built without the feature `parquet` answers 501.
         */
        get: operations["export_points_parquet"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/pump-downs": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The pump-downs of a series beside the usual ones, the latest first */
        get: operations["pump_downs"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/report.html": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** A report about a pump-down: curves, times, rises, the numbers of the plant, and the usual times, as one HTML file */
        get: operations["report"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/rise": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** A rise of pressure after a valve was closed, separated into a leak and outgassing */
        get: operations["rise"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/segments": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The segments with the stations on them */
        get: operations["segments"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/segments/{name}/bus": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * The live list and the statistics of a segment
         * @description What the station hears on the line, also on a segment on which it only listens.
         */
        get: operations["bus"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/segments/{name}/captures": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The captures of a segment, oldest first */
        get: operations["captures"];
        put?: never;
        /** Make a capture of the last minute and the next five seconds */
        post: operations["trigger"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/segments/{name}/captures/{file}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** A capture as a file for Wireshark and `profivac decode` */
        get: operations["capture"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/session": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The user of this session */
        get: operations["session"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/station": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The station and its recorder */
        get: operations["station"];
        put?: never;
        post?: never;
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
        /** The trend of a series: minimum, maximum and mean of each pixel */
        get: operations["trend"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/webhooks": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The webhooks with the status of their deliveries */
        get: operations["webhooks"];
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
        /** @description The occurrence of an alarm that the user has seen. */
        Acknowledge: {
            /**
             * Format: int64
             * @description The number of the occurrence, as the alarm shows it.
             * @example 3
             */
            occurrence: number;
        };
        /** @description The alarms that the user has seen. */
        AcknowledgeAll: {
            /** @description 1 to 1000 alarms. */
            alarms: components["schemas"]["AcknowledgeOne"][];
        };
        /** @description The result of acknowledging several alarms. */
        AcknowledgeAllResult: {
            /** @description The names of the acknowledged alarms. */
            acknowledged: string[];
            /** @description The alarms that were not acknowledged. */
            refused: components["schemas"]["RefusedAlarm"][];
        };
        /** @description An occurrence of an alarm that the user has seen. */
        AcknowledgeOne: {
            /**
             * @description The name of the alarm.
             * @example chamber: fault
             */
            name: string;
            /**
             * Format: int64
             * @description The number of the occurrence, as the alarm shows it.
             * @example 3
             */
            occurrence: number;
        };
        /**
         * @description The kind of a change of an alarm.
         * @enum {string}
         */
        AlarmChangeKind: "raised" | "returned" | "acknowledged" | "shelved" | "unshelved" | "taken-out-of-service" | "returned-to-service" | "suppressed" | "unsuppressed" | "removed" | "settings-changed";
        /** @description The number of alarms of a priority. */
        AlarmCount: {
            /** @description Alarms whose condition is met. */
            active: number;
            /** @description Alarms that wait for an acknowledgement, whether their condition is still met or not. */
            unacknowledged: number;
        };
        /** @description A row of the alarm history. */
        AlarmHistoryEntry: {
            /** @description The alarm. */
            alarm: string;
            /**
             * Format: int64
             * @description When it happened.
             */
            at_ms: number;
            /** @description The change. */
            change: components["schemas"]["AlarmChangeKind"];
            /**
             * Format: int64
             * @description The number of the occurrence.
             */
            occurrence: number;
            /** @description The priority at that time. */
            priority: components["schemas"]["Priority"];
            /** @description The state after the change. */
            state: components["schemas"]["AlarmState"];
            /** @description The series, gauge or segment. */
            subject: string | null;
            /** @description A sentence. */
            text: string;
            /** @description The unit of the value. */
            unit: string | null;
            /** @description The user who made the change; `null` if the station did. */
            user: string | null;
            /**
             * Format: double
             * @description The value at that time.
             */
            value: number | null;
        };
        /** @description The alarms at one moment, in numbers. */
        AlarmOverview: {
            /** @description Alarms of high priority. */
            high: components["schemas"]["AlarmCount"];
            /** @description Alarms of low priority. */
            low: components["schemas"]["AlarmCount"];
            /** @description Alarms of medium priority. */
            medium: components["schemas"]["AlarmCount"];
            /** @description The number of alarms out of service. */
            out_of_service: number;
            /** @description The declared plant states, in the order of the station's file. */
            plant_states: components["schemas"]["DeclaredPlantState"][];
            /** @description Why this overview may be wrong: the alarms were not evaluated for a while, or cannot be stored. */
            problem: string | null;
            /** @description The number of shelved alarms. */
            shelved: number;
            /** @description The number of alarms that a plant state suppresses. */
            suppressed: number;
        };
        /** @description Figures about the alarms of a time range. */
        AlarmPerformance: {
            /** @description Alarms raised, by priority. */
            by_priority: components["schemas"]["RaisedByPriority"];
            /** @description Alarms that were raised three times within a minute at least once, by name. */
            chattering: string[];
            /**
             * Format: double
             * @description The part of the recorded time, in percent, in periods of ten minutes with more than ten alarms; `null` if the station did not
             *     record.
             */
            flood_percent: number | null;
            /**
             * Format: int64
             * @description The beginning, in milliseconds since 1970.
             */
            from_ms: number;
            /** @description Alarms that are active now, for longer than a day, by name. */
            long_active: string[];
            /** @description The alarms that were raised most often, up to ten. */
            most_frequent: components["schemas"]["FrequentAlarm"][];
            /**
             * Format: double
             * @description Alarms per hour; `null` if the station did not record.
             */
            per_hour: number | null;
            /**
             * Format: int64
             * @description Alarms that were raised.
             */
            raised: number;
            /**
             * Format: double
             * @description The time in hours in which the station recorded. The rates refer to it.
             */
            recorded_hours: number;
            /**
             * Format: int64
             * @description How often a declared plant state suppressed an alarm. These are not among the raised ones.
             */
            suppressed: number;
            /**
             * Format: int64
             * @description The end, in milliseconds since 1970.
             */
            to_ms: number;
            worst_ten_minutes: components["schemas"]["TenMinutes"] | null;
        };
        /** @description The settings of an `[[alarm]]` as the file writes them; `null` is a key that the file does not have, so that its default applies. */
        AlarmSettings: {
            /**
             * @description The alarm is raised above this pressure.
             * @example 1e-3 mbar
             */
            above: string | null;
            /** @description The alarm is raised below this pressure. */
            below: string | null;
            /**
             * Format: double
             * @description The alarm is raised above this percentage of damaged telegrams.
             */
            damaged: number | null;
            /**
             * @description The condition must be met for this time.
             * @example 1 s
             */
            delay: string | null;
            /**
             * Format: double
             * @description The hysteresis in decades, or in decades per minute.
             */
            hysteresis: number | null;
            /**
             * Format: double
             * @description The alarm is raised above this percentage of lost message cycles.
             */
            lost: number | null;
            /**
             * @description The condition must not be met for this time.
             * @example 5 s
             */
            off_delay: string | null;
            /**
             * @description The priority: high, medium, low.
             * @example high
             */
            priority: string | null;
            /**
             * Format: double
             * @description The alarm is raised above this percentage of repetitions.
             */
            repetitions: number | null;
            /** @description The pressure at which the condition ends. */
            reset: string | null;
            /**
             * Format: double
             * @description The alarm is raised by a rise of this many decades per minute.
             */
            rise: number | null;
            /** @description The time over which a rise is fitted. */
            window: string | null;
        };
        /**
         * @description The state of an alarm.
         * @enum {string}
         */
        AlarmState: "normal" | "unacknowledged" | "acknowledged" | "returned" | "shelved" | "out-of-service" | "suppressed";
        /** @description An alarm. */
        AlarmView: {
            /** @description The user who acknowledged it. */
            acknowledged_by: string | null;
            /**
             * Format: int64
             * @description When it was acknowledged.
             */
            acknowledged_ms: number | null;
            /** @description The kind of its condition. */
            condition: components["schemas"]["ConditionKind"];
            /** @description The gauge, if the alarm is about one. */
            gauge: string | null;
            /**
             * Format: double
             * @description The limit.
             */
            limit: number | null;
            /** @description The instruction for the operator, from the station's file. */
            message: string | null;
            /** @description The name. */
            name: string;
            /**
             * Format: int64
             * @description The number of the last occurrence, needed to acknowledge it; 0 if the alarm was never raised.
             */
            occurrence: number;
            out_of_service: components["schemas"]["SuppressionView"] | null;
            /** @description How soon an operator must respond. */
            priority: components["schemas"]["Priority"];
            /**
             * Format: int64
             * @description When it was raised last.
             */
            raised_ms: number | null;
            /**
             * Format: double
             * @description The value that raised it.
             */
            raised_value: number | null;
            /**
             * Format: double
             * @description The value at which the condition ends.
             */
            reset: number | null;
            /** @description The segment, if the alarm is about one. */
            segment: string | null;
            /** @description The measuring part, by the name under which it is recorded, if the alarm is about one. */
            series: string | null;
            several: components["schemas"]["SeveralView"] | null;
            shelved: components["schemas"]["SuppressionView"] | null;
            /**
             * Format: int64
             * @description The time of the last change; `null` if there was none.
             */
            since_ms: number | null;
            /** @description The state. */
            state: components["schemas"]["AlarmState"];
            suppressed: components["schemas"]["SuppressionView"] | null;
            /** @description A sentence about why it was raised. */
            text: string;
            /** @description The unit of values and limits. */
            unit: string | null;
            /**
             * Format: double
             * @description The present value.
             */
            value: number | null;
        };
        /** @description What waits for the archive, and what it says about the station. */
        ArchiveView: {
            /**
             * Format: int64
             * @description When the archive last said what its database has, in milliseconds since 1970.
             */
            last_answer_ms: number | null;
            /**
             * Format: int64
             * @description Batches that were deleted since the last one was taken, because too many wait.
             */
            lost: number;
            /**
             * Format: int64
             * @description When the first of them was made, in milliseconds since 1970.
             */
            oldest_ms: number | null;
            /**
             * Format: int64
             * @description Batches of the station that the archive has put aside.
             */
            put_aside: number;
            /** @description Why it has put the last one aside, in a sentence. */
            put_aside_reason: string | null;
            /**
             * Format: int64
             * @description Batches that wait in the database of the station.
             */
            waiting: number;
        };
        /** @description An armed command or write. */
        ArmedCommandView: {
            /** @description The requested value with its unit. */
            after: string;
            /** @description The present value with its unit; `null` if it cannot be read. */
            before: string | null;
            /** @description The conditions, which are all met. */
            conditions: components["schemas"]["ConditionView"][];
            /**
             * Format: int64
             * @description The time until it is disarmed, in milliseconds.
             */
            expires_in_ms: number;
            /** @description Whether a device file describes it: its conditions and its risk are as good as the file. */
            from_device_file: boolean;
            /** @description The gauge. */
            gauge: string;
            /** @description Its identifier. */
            id: string;
            /** @description Whether it is a command; otherwise it writes a parameter. */
            is_command: boolean;
            /** @description The manual's name and numbers of the parameter. */
            manual_name: string;
            /** @description The octets that will be sent, in hex. */
            octets: string;
            /** @description The risk of executing it. */
            risk: components["schemas"]["Risk"];
            /** @description The name of the command, or of the parameter. */
            target: string;
        };
        /**
         * @description The action of an audit entry.
         * @enum {string}
         */
        AuditAction: "execute" | "outcome" | "refused" | "disarmed" | "control-authority" | "acknowledged" | "shelved" | "unshelved" | "taken-out-of-service" | "returned-to-service" | "alarm-settings" | "plant-state-declared" | "plant-state-extended" | "plant-state-ended" | "backup" | "file-changed";
        /** @description An entry of the audit trail. */
        AuditEntry: {
            /** @description The action. */
            action: components["schemas"]["AuditAction"];
            /**
             * Format: int32
             * @description The bus address of the gauge.
             */
            address: number | null;
            /** @description The requested value; for an `outcome`, the value that was read back. */
            after: string | null;
            /**
             * Format: int64
             * @description The time, in milliseconds since 1970.
             */
            at_ms: number;
            /** @description The value before the action. */
            before: string | null;
            /** @description The identifier of the armed command. */
            command_id: string | null;
            /** @description The gauge. */
            gauge: string | null;
            /**
             * Format: int64
             * @description The number of the entry. Later entries have higher numbers. An entry that is not written yet has 0.
             */
            id: number;
            /** @description The result, in a sentence. */
            outcome: string | null;
            /** @description The address of the user's computer. */
            peer: string | null;
            /**
             * Format: int64
             * @description For an `outcome` or `disarmed`, the number of the entry that it belongs to.
             */
            refers_to: number | null;
            /** @description The role of the user at that time. */
            role: components["schemas"]["Role"];
            /** @description The segment of the gauge. */
            segment: string | null;
            /** @description The manual's name and numbers of the parameter, or the name of the alarm or plant state. */
            target: string | null;
            /** @description The name of the user. */
            user: string;
        };
        /** @description A copy of the database that is ready to be downloaded. */
        BackupView: {
            /** @description The name of the copy in the path of its download. */
            id: string;
            /**
             * Format: int64
             * @description Until when a download begins, in milliseconds since 1970. A later copy ends this one.
             */
            kept_until_ms: number;
            /**
             * Format: int64
             * @description When the copy was made, in milliseconds since 1970.
             */
            made_ms: number;
            /**
             * Format: int64
             * @description The size of the copy.
             */
            octets: number;
        };
        /** @description A block of a gauge with its parameters. */
        Block: {
            /** @description The manual's name of the block. */
            name: string;
            /** @description Its parameters. */
            parameters: components["schemas"]["Parameter"][];
        };
        /** @description A value with its 95 % interval. */
        BoundsView: {
            /**
             * Format: double
             * @description The upper bound; `null` if there is none.
             */
            high: number | null;
            /**
             * Format: double
             * @description The lower bound.
             */
            low: number;
            /**
             * Format: double
             * @description The best value.
             */
            mean: number;
        };
        /** @description A bucket of durations. */
        Bucket: {
            /**
             * Format: int64
             * @description The number of durations.
             */
            count: number;
            /**
             * Format: int64
             * @description Its end in microseconds.
             */
            end_us: number;
        };
        /** @description The state of a line. */
        BusReport: {
            /**
             * Format: int32
             * @description The baud rate in bit/s.
             */
            baud: number;
            /** @description The duration of the cycles of all masters. */
            cycle: components["schemas"]["Distribution"];
            /**
             * Format: int64
             * @description Damaged pieces.
             */
            damaged: number;
            /**
             * Format: int64
             * @description Damaged pieces of the last minute.
             */
            damaged_last_minute: number;
            /**
             * Format: int64
             * @description Damaged pieces that belong to no station that is known.
             */
            damaged_unattributed: number;
            /** @description The last events, newest first. */
            events: components["schemas"]["EventReport"][];
            /** @description The masters. */
            masters: components["schemas"]["MasterReport"][];
            /**
             * Format: int64
             * @description For how long the line was observed, in milliseconds of bus time.
             */
            observed_ms: number;
            /**
             * Format: int64
             * @description Octets of telegrams and of damaged pieces.
             */
            octets: number;
            /** @description The parameters that passed. */
            parameters: components["schemas"]["ParameterReport"][];
            /**
             * Format: int64
             * @description The memory that the flight recorder of the line has taken, in octets; 0 without one.
             */
            recorder_octets: number;
            /** @description The masters in the order of the token. */
            ring: number[];
            /** @description The time between two tokens to the same master. */
            rotation: components["schemas"]["Distribution"];
            /** @description The live list, by address. */
            stations: components["schemas"]["StationReport"][];
            /**
             * Format: int64
             * @description Valid telegrams.
             */
            telegrams: number;
        };
        /** @description A station on a segment. */
        BusStation: {
            /**
             * Format: int32
             * @description Its address, 0 to 126.
             */
            address: number;
            /** @description A description of the state. */
            description: string;
            /** @description The device, if it is known. */
            device: string | null;
            /** @description Ident_Number, in hex. */
            ident: string | null;
            /** @description The name in the station's file. */
            name: string | null;
            /** @description The state. */
            state: components["schemas"]["BusStationState"];
        };
        /**
         * @description The state of a station on the bus.
         * @enum {string}
         */
        BusStationState: "own-master" | "other-master" | "data-exchange" | "fault" | "starting" | "missing" | "unconfigured";
        /** @description A capture of the traffic of a segment */
        CaptureView: {
            /** @description The name of the file. */
            name: string;
            /**
             * Format: int64
             * @description Its size in octets.
             */
            octets: number;
        };
        /**
         * @description The parts of the snapshot that have changed. `segments`, `gauges` and `standing_alarms` have the entries that have changed, and `null` for
         *     one that is gone; the other parts are whole.
         */
        Change: Record<string, never>;
        /** @description New settings of a default alarm. */
        ChangeDefaultSettings: {
            /** @description The new settings, all of them. */
            new: components["schemas"]["DefaultAlarmSettings"];
            /**
             * @description The reason, in one line of 1 to 500 characters.
             * @example a restart of the gauge takes longer
             */
            reason: string;
            /** @description The settings that the user has seen. */
            seen: components["schemas"]["DefaultAlarmSettings"];
        };
        /** @description New settings of an alarm. */
        ChangeSettings: {
            /** @description The new settings, all of them. */
            new: components["schemas"]["AlarmSettings"];
            /**
             * @description The reason, in one line of 1 to 500 characters.
             * @example the process needs a lower pressure
             */
            reason: string;
            /** @description The settings that the user has seen. */
            seen: components["schemas"]["AlarmSettings"];
        };
        /** @description The result of shelving or unshelving several alarms. */
        ChangedAlarms: {
            /** @description The names of the changed alarms. */
            changed: string[];
            /** @description The alarms that were not changed. */
            refused: components["schemas"]["RefusedAlarm"][];
        };
        /** @description When the valve to the pump was closed. */
        ClosedView: {
            /**
             * Format: double
             * @description Seconds after the start.
             */
            closed_s: number;
            /**
             * Format: double
             * @description When it was opened again, or the samples end: seconds after the start.
             */
            opened_s: number;
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
        /** @description A command of a gauge. */
        Command: {
            /** @description Why it cannot be executed from the station; `null` if it can. */
            blocked_reason: string | null;
            /**
             * @description The name by which it is armed.
             * @example ba.degas-on
             */
            command: string;
            /** @description The conditions that must be met. */
            conditions: string[];
            /** @description Whether a device file describes it: its conditions and its risk are as good as the file. */
            from_device_file: boolean;
            /** @description The manual's name of the parameter that carries it. */
            name: string;
            /** @description Slot and index of that parameter. */
            numbers: string;
            /** @description The risk of executing it. */
            risk: components["schemas"]["Risk"];
            /** @description The lowest role that may execute it. */
            role: components["schemas"]["Role"];
        };
        /**
         * @description The kind of the condition of an alarm.
         * @enum {string}
         */
        ConditionKind: "above" | "below" | "rise" | "several" | "point" | "not-measurable" | "fault" | "stale" | "segment-down" | "damaged-telegrams" | "bus-rate" | "not-recording" | "database-damaged" | "not-archived";
        /** @description A condition of a command, and whether it is met. */
        ConditionView: {
            /** @description The expected state. */
            expected: string;
            /** @description The state that was found. */
            found: string;
            /** @description Whether the condition is met. */
            is_met: boolean;
        };
        /** @description A problem document with the conditions of a command. */
        ConflictView: components["schemas"]["Problem"] & {
            /** @description All conditions of the command, if one of them is not met. */
            conditions: components["schemas"]["ConditionView"][];
        };
        /** @description The user who has control. */
        ControlAuthorityView: {
            /** @description The user; `null` if control is free. */
            holder: string | null;
            /** @description The user who requests control. */
            requested_by: string | null;
            /**
             * Format: int64
             * @description Since when.
             */
            requested_ms: number | null;
            /**
             * Format: int64
             * @description Since when, in milliseconds since 1970.
             */
            since_ms: number | null;
        };
        /** @description What happened to the requests to a station. */
        Counts: {
            /**
             * Format: int64
             * @description Damaged answers, and damaged requests that were repeated.
             */
            damaged: number;
            /**
             * Format: int64
             * @description Diagnoses that were fetched.
             */
            diagnoses: number;
            /**
             * Format: int64
             * @description Data_Exchange cycles with a valid answer.
             */
            exchanges: number;
            /**
             * Format: int64
             * @description Message cycles that their master gave up: neither the request nor a repetition had a valid answer.
             */
            lost: number;
            /**
             * Format: int64
             * @description Answers that refuse: UE, RR, RS, RDL, RDH, and negative responses of DP-V1.
             */
            refused: number;
            /**
             * Format: int64
             * @description Repetitions, also those of requests that were received damaged.
             */
            repeated: number;
            /**
             * Format: int64
             * @description Requests with their repetitions, also damaged ones that were repeated; without FDL status.
             */
            requests: number;
            /**
             * Format: int64
             * @description Requests without any answer.
             */
            unanswered: number;
        };
        /** @description Why a plant state is declared or extended, and for how long. */
        Declare: {
            /**
             * Format: int32
             * @description The time in minutes from now, 1 to the longest time of the plant state.
             */
            minutes: number;
            /**
             * @description The reason, in one line of 1 to 500 characters.
             * @example the target is changed
             */
            reason: string;
        };
        /** @description A declared plant state. */
        DeclaredPlantState: {
            /**
             * Format: int64
             * @description When.
             */
            at_ms: number;
            /** @description The name of the plant state. */
            name: string;
            /** @description The reason of the declaration, or of the last extension. */
            reason: string;
            /**
             * Format: int64
             * @description When it ends by itself.
             */
            until_ms: number;
            /** @description The user who declared it. */
            user: string;
        };
        /** @description The settings of a default alarm as the file writes them; `null` is a key that the file does not have, so that its default applies. */
        DefaultAlarmSettings: {
            /**
             * @description The condition must be met for this time.
             * @example 10 s
             */
            delay: string | null;
            /** @description The gauges or segments without this alarm, up to 1000. */
            except: string[] | null;
            /**
             * Format: double
             * @description For `damage` only: the damaged telegrams in a minute.
             */
            limit: number | null;
            /**
             * @description The condition must not be met for this time.
             * @example 5 s
             */
            off_delay: string | null;
            /**
             * @description The priority: high, medium, low, or off: then there is no such alarm.
             * @example high
             */
            priority: string | null;
        };
        /** @description A default alarm, which every gauge, every segment or the station has. */
        DefaultAlarmView: {
            /** @description What holds where the file has no setting. */
            defaults: components["schemas"]["DefaultAlarmSettings"];
            /**
             * @description Its name in the table `[alarms]` of the station's file.
             * @example stale
             */
            name: string;
            /** @description The settings, as the file writes them. */
            settings: components["schemas"]["DefaultAlarmSettings"];
        };
        /** @description A point with the texts of its codes. The recorder stores numbers; the texts are those of the station's file. */
        DescribedPoint: components["schemas"]["RecordedPoint"] & {
            /** @description The texts of its codes; empty for a number, and for a point that the station's file does not have. */
            texts: components["schemas"]["CodeText"][];
        };
        /** @description A deviation from the usual pump-downs. */
        DeviationView: {
            /** @description The shape of the pressure above the usual one; `null` if it is none of these, or too small. */
            excess: ("leak" | "outgassing" | "virtual-leak") | null;
            /** @description What it looks like, in words. */
            likeness: string;
            pattern: ("from-the-beginning" | "at-low-pressure" | "at-high-pressure") & Record<string, never>;
            /**
             * Format: int64
             * @description The beginning of the first of the deviating pump-downs in a row, in milliseconds since 1970.
             */
            since_ms: number;
            /**
             * @description The deviation at the lowest deviating pressure, in words.
             * @example 20 min later to 1e-5 mbar than usual: 80 min; usual 60 min, the median of the last 10, at most 66 min
             */
            text: string;
        };
        /** @description An earlier diagnosis. */
        DiagnosisReport: {
            /**
             * Format: int64
             * @description How long ago it was fetched, in milliseconds.
             */
            age_ms: number;
            /** @description What it reports. */
            reports: string[];
        };
        /** @description The directory of the station. */
        Directory: {
            /** @description The labels of the gauges, by name. A gauge without labels is not listed. */
            gauges: {
                [key: string]: components["schemas"]["GaugeLabels"];
            };
            /** @description The views of all users, in the order of the file. */
            views: components["schemas"]["SavedView"][];
        };
        /** @description Durations. */
        Distribution: {
            /** @description The buckets that have durations, a quarter of an octave each. */
            buckets: components["schemas"]["Bucket"][];
            /**
             * Format: int64
             * @description The number of durations.
             */
            count: number;
            /**
             * Format: int64
             * @description The longest in microseconds.
             */
            max_us: number | null;
            /**
             * Format: int64
             * @description The mean in microseconds.
             */
            mean_us: number | null;
            /**
             * Format: int64
             * @description The shortest in microseconds.
             */
            min_us: number | null;
            /**
             * Format: int64
             * @description An upper bound of 99 % of the durations in microseconds.
             */
            p99_us: number | null;
        };
        /**
         * @description What a master did with a parameter.
         * @enum {string}
         */
        Done: "read" | "written" | "refused";
        /** @description Why a plant state is ended. */
        End: {
            /**
             * @description The reason, in one line of 1 to 500 characters; without it the audit trail has none.
             * @example the target is changed
             */
            reason?: string | null;
        };
        /** @description Something that happened. */
        Event: {
            /**
             * Format: int64
             * @description When, in milliseconds since 1970.
             */
            at_ms: number;
            /** @description The gauge, if the event is about one. */
            gauge: string | null;
            /** @description The kind. */
            kind: components["schemas"]["StationEventKind"];
            /** @description One sentence. */
            text: string;
        };
        /**
         * @description The subject of an event.
         * @enum {string}
         */
        EventKind: "lost" | "returned" | "configuration" | "owner" | "diagnosis" | "refused" | "parameter" | "burst" | "ring";
        /** @description An event. */
        EventReport: {
            /**
             * Format: int64
             * @description How long ago, in milliseconds.
             */
            age_ms: number;
            /** @description The subject. */
            kind: components["schemas"]["EventKind"];
            /**
             * Format: int64
             * @description Its number, counted from 1.
             */
            number: number;
            /**
             * Format: int32
             * @description The station; `null` for the line.
             */
            station: number | null;
            /** @description The sentence. */
            text: string;
        };
        /** @description An executed command or write. */
        ExecutedView: {
            /** @description The value that was read back, with its unit; `null` if it could not be read. */
            after: string | null;
            /** @description The value before, with its unit; `null` if it could not be read. */
            before: string | null;
            /** @description The gauge. */
            gauge: string;
            /** @description The identifier of the armed command. */
            id: string;
            /** @description The octets that were sent, in hex. */
            octets: string;
            /** @description The name of the command, or of the parameter. */
            target: string;
        };
        /** @description A gas flow in three units. */
        FlowView: {
            /** @description In mbar l/s. */
            mbar_l_per_s: components["schemas"]["IntervalView"];
            /** @description In Pa m³/s. */
            pa_m3_per_s: components["schemas"]["IntervalView"];
            /** @description In sccm at 0 °C and 1013.25 mbar, from the temperature of the gas. */
            sccm: components["schemas"]["IntervalView"];
        };
        /** @description An alarm and how often it was raised. */
        FrequentAlarm: {
            /** @description Its name. */
            alarm: string;
            /**
             * Format: double
             * @description That part of all raised alarms, in percent.
             */
            percent: number;
            /**
             * Format: int64
             * @description How often it was raised.
             */
            raised: number;
        };
        /** @description The state of a gateway. */
        GatewayView: {
            /** @description Where it listens, or the broker to which it connects. */
            address: string | null;
            archive: components["schemas"]["ArchiveView"] | null;
            /**
             * Format: int64
             * @description Connected clients; for a broker 1 while it is connected.
             */
            clients: number;
            /**
             * Format: int64
             * @description Updates that a slow client did not get because a newer one of the same value replaced them.
             */
            dropped_updates: number;
            /** @description Whether it serves its clients, or is connected to its broker. */
            is_running: boolean;
            /** @description The last error, in a sentence. */
            last_error: string | null;
            /**
             * Format: int64
             * @description When it occurred, in milliseconds since 1970.
             */
            last_error_ms: number | null;
            /** @description Its name: `archive`, `epics`, `opcua`, `mqtt`, `sparkplug`, `modbus`, `prometheus`. */
            name: string;
            /** @description Why it does not run; it tries again. */
            problem: string | null;
            /**
             * Format: int64
             * @description Requests and connections that were refused or could not be understood.
             */
            refused: number;
            /**
             * Format: int64
             * @description Values and answers that were sent since the station started.
             */
            sent: number;
        };
        /** @description A gauge, or another slave of the station's file. */
        Gauge: {
            /**
             * Format: int32
             * @description Its address.
             */
            address: number;
            /**
             * Format: int64
             * @description The age of the readings in milliseconds; `null` if there never was one.
             */
            age_ms: number | null;
            /** @description The assumptions about its configuration and unit, in sentences; its readings depend on it. Empty unless the station only listens. */
            assumptions: string[];
            /** @description The device: `bcg450`; of a slave vendor and model of its GSD file. */
            device: string;
            /** @description The alarms that it reports: its defects in the words of the manual, once the station has read them. */
            exceptions: string[];
            /** @description The gas for which the readings are corrected; empty for a slave. */
            gas: string;
            /** @description Whether the device has DP-V1: its parameters travel over MS2, those of other devices in the parameter channel. */
            has_dpv1: boolean;
            /** @description A gauge with readings, or a slave with points. */
            kind: components["schemas"]["GaugeKind"];
            /** @description Pressures that trends mark with a line. */
            levels: components["schemas"]["PressureLevel"][];
            /** @description Another master owns it and the station only listens: no parameter is read and no command is sent. */
            listen_only: boolean;
            /** @description Its name. */
            name: string;
            /** @description The parameters that gateways show beside the pressures, empty while no gateway runs; of a slave its points. */
            parameters: components["schemas"]["WatchedParameter"][];
            /**
             * Format: int64
             * @description The poll interval in milliseconds.
             */
            poll_ms: number;
            /** @description Why it is not in data exchange, in a sentence. */
            problem: string | null;
            /**
             * Format: int64
             * @description When the gauge gave the readings, in milliseconds since 1970; `null` if there never was one.
             */
            read_ms: number | null;
            /** @description The readings, one for each measuring part in the cyclic data. */
            readings: components["schemas"]["Reading"][];
            /** @description Its segment. */
            segment: string;
            /**
             * Format: int64
             * @description The age in milliseconds from which the readings are stale.
             */
            stale_after_ms: number;
            /** @description The state. */
            state: components["schemas"]["BusStationState"];
            /** @description The warnings that it reports, without those that the qualities of its readings explain. */
            warnings: string[];
        };
        /**
         * @description What the station knows of a slave in its file.
         * @enum {string}
         */
        GaugeKind: "gauge" | "slave";
        /** @description The labels of a gauge. */
        GaugeLabels: {
            /** @description The day of its last calibration, as `2026-05-01`. */
            calibrated: string | null;
            /** @description The last day on which the calibration is valid, as `2027-05-01`; `null` without an interval. */
            calibration_due: string | null;
            /** @description The group that it belongs to. */
            group: string | null;
            /** @description The place where it is mounted. */
            location: string | null;
            /** @description Its tags, in the order of the file. */
            tags: string[];
        };
        /** @description A value in a request. */
        GivenValue: string | number | boolean;
        /** @description A value with its 95 % interval. */
        IntervalView: {
            /**
             * Format: double
             * @description The upper bound.
             */
            high: number;
            /**
             * Format: double
             * @description The lower bound.
             */
            low: number;
            /**
             * Format: double
             * @description The mean.
             */
            mean: number;
        };
        /** @description A gauge with its labels. */
        LabelledGauge: components["schemas"]["Gauge"] & {
            /** @description What the station's file says about it beside the bus. */
            labels: components["schemas"]["GaugeLabels"];
        };
        /** @description The time to a pressure. */
        LevelView: {
            /** @description Whether the time deviates from the usual one, and how. */
            deviation: ("later" | "earlier") | null;
            /**
             * Format: double
             * @description The pressure in Pa.
             */
            pa: number;
            /**
             * Format: double
             * @description The time in seconds; `null` if it was not reached or lies in a gap.
             */
            s: number | null;
            usual: components["schemas"]["UsualView"] | null;
        };
        /**
         * @description The condition of each gauge of an alarm about several.
         * @enum {string}
         */
        LimitKind: "above" | "below" | "rise";
        /** @description Data of the live stream. The event `snapshot` comes first and once. */
        LiveEvent: components["schemas"]["Snapshot"] | components["schemas"]["Change"];
        /** @description The plant in the live stream. */
        LivePlant: {
            /**
             * Format: int64
             * @description Changes when `/api/plant` changes.
             */
            revision: number;
            /** @description The states of the parts, by name. A part without a state reports none. */
            states: {
                [key: string]: components["schemas"]["PlantPartStatus"];
            };
            /** @description What happens, the latest sentence first. Only a demonstration tells a story. */
            story: components["schemas"]["StorySentence"][];
        };
        /** @description Name and password of a user. */
        Login: {
            /**
             * @description The name.
             * @example ada
             */
            name: string;
            /** @description The password. */
            password: string;
        };
        /**
         * @description Whether the user has to log in, and has.
         * @enum {string}
         */
        LoginState: "not-required" | "logged-in" | "logged-out";
        /** @description A master. */
        MasterReport: {
            /**
             * Format: int32
             * @description Its address.
             */
            address: number;
            /** @description The duration of its cycles. */
            cycle: components["schemas"]["Distribution"];
            /** @description The time between two tokens. */
            rotation: components["schemas"]["Distribution"];
        };
        /** @description What a user notes. */
        NewNote: {
            /**
             * Format: int64
             * @description The time that the note is about, in milliseconds since 1970, not after the present; without it the present.
             * @example 1767225600000
             */
            at_ms?: number | null;
            /**
             * @description The name of the gauge that the note is about.
             * @example chamber
             */
            gauge?: string | null;
            /**
             * @description One line of 1 to 500 characters.
             * @example the cold trap is filled
             */
            text: string;
        };
        /** @description A user's change of the password. */
        NewPassword: {
            /** @description The current password. */
            current: string;
            /** @description The new password, 8 characters at least. */
            new: string;
        };
        /** @description The beginning of a login at the OpenID provider. */
        OpenIdBegin: Record<string, never>;
        /** @description What the browser brings back from the OpenID provider: the parameters of the address of the page `/openid`. */
        OpenIdLogin: {
            /** @description The code, if the login has succeeded. */
            code?: string | null;
            /** @description The code of an error, if it has not. */
            error?: string | null;
            /** @description The issuer, if the provider sends it. */
            iss?: string | null;
            /** @description The state of the login. */
            state: string;
        };
        /** @description A request to arm a command, or a parameter with its value. */
        OperationRequest: {
            /** @description The command: `degas-on`, `ba.degas-on`. */
            command?: string | null;
            /** @description Writes a pressure outside the measuring range of the gauge; the audit trail says so. */
            force?: boolean;
            /** @description The parameter: `trip-point.1/high-trip-point`, `2/61`. */
            target?: string | null;
            value?: components["schemas"]["GivenValue"] | null;
        };
        /**
         * @description Where a fact about a slave comes from. An earlier one is stronger.
         * @enum {string}
         */
        Origin: "heard" | "configured" | "assumed";
        /** @description A parameter of a gauge. */
        Parameter: {
            /** @description The access that the manual allows: `R`, `R/W`, ... */
            access: string;
            /** @description The manual's name. */
            name: string;
            /** @description Slot and index, or the number of the parameter channel. */
            numbers: string;
            /** @description Why it could not be read. */
            read_error: string | null;
            /** @description The name by which it is read and written: `trip-point.1/high-trip-point`. */
            target: string;
            /** @description The present value with its unit; `null` if it could not be read. */
            value: string | null;
            write: components["schemas"]["WriteInfo"] | null;
        };
        /** @description A parameter that passed. */
        ParameterReport: {
            /**
             * Format: int32
             * @description The slave.
             */
            address: number;
            /**
             * Format: int64
             * @description How long ago it passed, in milliseconds.
             */
            age_ms: number;
            /** @description The result. */
            done: components["schemas"]["Done"];
            /** @description The name of the parameter with its numbers. */
            name: string;
            /** @description The access path. */
            path: components["schemas"]["Path"];
            /**
             * Format: int32
             * @description The master that asked.
             */
            requester: number;
            /** @description The value; empty if the slave refused. */
            value: string;
        };
        /** @description A number of a plant. */
        ParameterView: {
            certainty: ("determined" | "upper-bound" | "undetermined") & Record<string, never>;
            /** @description Why it is not determined and what to record, in words; `null` if it is. */
            note: string | null;
            /** @description The value with its 95 % interval. */
            value: components["schemas"]["BoundsView"];
        };
        /** @description The parts of a pressure, in Pa. */
        PartsView: {
            /** @description By the leak. */
            by_leak: components["schemas"]["BoundsView"];
            /** @description By outgassing. */
            by_outgassing: components["schemas"]["BoundsView"];
            /** @description By the ultimate pressure of the pump. */
            by_pump: components["schemas"]["BoundsView"];
        };
        /**
         * @description The access path of a parameter.
         * @enum {string}
         */
        Path: "parameter-channel" | "ms1" | "ms2";
        /** @description A gas flow of a plant. */
        PlantFlowView: {
            certainty: ("determined" | "upper-bound" | "undetermined") & Record<string, never>;
            /** @description The flow in three units. */
            flow: components["schemas"]["FlowView"];
            /** @description Why it is not determined and what to record, in words; `null` if it is. */
            note: string | null;
        };
        /** @description A part of the plant: a valve, a tube, a pump or an opening to the outside. */
        PlantPart: {
            /** @description Its kind. */
            kind: components["schemas"]["PlantPartKind"];
            /** @description Its name. */
            name: string;
            /** @description Its volumes. A tube or valve has two, a pump its inlet and perhaps the volume that it pumps into, an opening one. */
            volumes: string[];
        };
        /**
         * @description The kind of a part.
         * @enum {string}
         */
        PlantPartKind: "tube" | "valve" | "roughing-pump" | "turbo-pump" | "capture-pump" | "leak" | "vent" | "inlet";
        /**
         * @description The state of a part.
         * @enum {string}
         */
        PlantPartState: "open" | "closed" | "running" | "stopped";
        /** @description The reported state of a part. */
        PlantPartStatus: {
            /** @description More about it: the speed of a rotor. */
            detail: string | null;
            /** @description The state. */
            state: components["schemas"]["PlantPartState"];
        };
        /** @description The plant: what stands between what. */
        PlantPicture: {
            /** @description The user's own drawing as SVG, in which `data-gauge`, `data-volume` and `data-part` name gauges, volumes and parts. */
            drawing: string | null;
            /** @description The parts between them. */
            parts: components["schemas"]["PlantPart"][];
            /** @description The volumes; empty if nothing describes the plant. */
            volumes: components["schemas"]["PlantVolume"][];
        };
        /** @description A plant state. */
        PlantStateView: {
            /** @description The names of the alarms that it suppresses while it is declared. */
            alarms: string[];
            declared: components["schemas"]["DeclaredPlantState"] | null;
            /** @description A sentence about it, from the station's file. */
            description: string | null;
            /**
             * Format: int64
             * @description The longest time in minutes for which it is declared or extended.
             */
            longest_minutes: number;
            /** @description The name. */
            name: string;
            /** @description The lowest role that declares and extends it. */
            role: components["schemas"]["Role"];
        };
        /** @description A plant identified from the samples of one gauge. */
        PlantView: {
            /**
             * Format: double
             * @description The accuracy of the gauge that the intervals contain, as a fraction; `null` if it was not given.
             */
            accuracy: number | null;
            /** @description The pressure after another day of pumping in Pa, as indicated. */
            after_another_day_pa: components["schemas"]["BoundsView"];
            /** @description The parts of the pressure at the end of the samples with the valve open, in Pa as indicated. */
            at_end_pa: components["schemas"]["PartsView"];
            /**
             * Format: double
             * @description The seconds after the start at which the samples end.
             */
            end_s: number;
            /** @description The exponent of the outgassing over time: 1 for water on metals, 1/2 for diffusion. */
            exponent: components["schemas"]["ParameterView"];
            /** @description Whether the fit describes the samples: the misfit is at most 2. If not, the numbers are worth nothing. */
            is_described: boolean;
            /** @description Whether the volume was given. */
            is_volume_given: boolean;
            /** @description The leak, as air. */
            leak: components["schemas"]["PlantFlowView"];
            /**
             * Format: double
             * @description The root mean square of the residuals divided by the noise: near 1 for a good fit.
             */
            misfit: number;
            /** @description The outgassing after an hour, as water. */
            outgassing_1h: components["schemas"]["PlantFlowView"];
            /** @description The predicted pressure if the pumping goes on from the start until a day after the last sample, with its band. */
            prediction: components["schemas"]["PredictionView"][];
            /** @description Changes that lower the pressure, the best one first. */
            remedies: components["schemas"]["RemedyView"][];
            /** @description Groups of samples beside the fit. */
            residuals: components["schemas"]["ResidualView"][];
            rise: components["schemas"]["ClosedView"] | null;
            /** @description The number of fitted samples. */
            samples: number;
            /** @description The series. */
            series: string;
            /** @description The effective pumping speed, from low to high pressure. */
            speeds: components["schemas"]["SpeedView"][];
            /** @description Changes of the indication that look like helium at a leak, the earliest first. */
            sprays: components["schemas"]["SprayView"][];
            /**
             * Format: int64
             * @description The start of the samples, in milliseconds since 1970.
             */
            start_ms: number;
            target_s: components["schemas"]["TimeView"] | null;
            /** @description The ultimate pressure of the pump in Pa, as indicated. */
            ultimate_pa: components["schemas"]["ParameterView"];
            /** @description The volume in m³. */
            volume_m3: components["schemas"]["ParameterView"];
        };
        /** @description A volume of the plant. */
        PlantVolume: {
            /** @description Its gauges. The name of a gauge stands for all its readings that no other volume has; `name.N` is the channel N of a controller. */
            gauges: string[];
            /** @description Its name. */
            name: string;
            /** @description The zone that it belongs to. */
            zone: string | null;
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
        /** @description A predicted pressure. */
        PredictionView: {
            /** @description The pressure in Pa with its 95 % band. */
            pa: components["schemas"]["BoundsView"];
            /**
             * Format: double
             * @description Seconds after the start.
             */
            s: number;
        };
        /** @description A pressure that a trend marks with a line. */
        PressureLevel: {
            /** @description The name. */
            name: string;
            /**
             * Format: double
             * @description In Pa.
             */
            pa: number;
        };
        /**
         * @description The principle by which a measuring part senses pressure.
         * @enum {string}
         */
        Principle: "pirani" | "hot-cathode" | "cold-cathode" | "diaphragm" | "atmosphere";
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
        /** @description Where the browser continues. */
        ProviderAddress: {
            /**
             * @description An address of the OpenID provider.
             * @example https://login.example/realms/lab/protocol/openid-connect/auth?response_type=code
             */
            url: string;
        };
        /** @description A pump-down beside the usual ones. */
        PumpDownView: {
            /** @description At most 120 points, evenly on a logarithmic axis of time. */
            curve: components["schemas"]["RisePoint"][];
            deviation: components["schemas"]["DeviationView"] | null;
            /**
             * Format: int64
             * @description The last sample or the venting, in milliseconds since 1970.
             */
            end_ms: number;
            /** @description Whether a venting ended it. */
            is_vented: boolean;
            /** @description The times to each decade of mbar, the highest pressure first. */
            levels: components["schemas"]["LevelView"][];
            /**
             * Format: double
             * @description The lowest pressure in Pa.
             */
            lowest_pa: number;
            /** @description Changes of the indication that look like helium at a leak, the earliest first. */
            sprays: components["schemas"]["SprayView"][];
            /**
             * Format: int64
             * @description The beginning, in milliseconds since 1970.
             */
            start_ms: number;
            /**
             * Format: double
             * @description The pressure at the beginning in Pa.
             */
            start_pa: number;
        };
        /** @description Compared pump-downs of one series. */
        PumpDowns: {
            /** @description The number of pump-downs in the time range; `runs` may have fewer. */
            found: number;
            /** @description The pump-downs, the latest first. */
            runs: components["schemas"]["PumpDownView"][];
            /** @description The series. */
            series: string;
        };
        /**
         * @description The state of a reading: whether it is a pressure, and if not, why.
         * @enum {string}
         */
        Quality: "valid" | "overrange" | "underrange" | "fault" | "stale" | "off" | "missing" | "assumed";
        /** @description Alarms raised, by priority. */
        RaisedByPriority: {
            /**
             * Format: int64
             * @description High.
             */
            high: number;
            /**
             * Format: int64
             * @description Low.
             */
            low: number;
            /**
             * Format: int64
             * @description Medium.
             */
            medium: number;
        };
        /** @description The progress of reading the parameters of a gauge. */
        ReadProgress: {
            /** @description The number of parameters that were read. */
            done: number;
            /** @description The gauge. */
            gauge: string;
            /** @description The number of all parameters. */
            total: number;
        };
        /** @description The reading of a measuring part. */
        Reading: {
            /** @description The cause of the quality, in a few words, where the gauge reports one; for `assumed` the pressure that the assumption gives. */
            cause: string | null;
            /**
             * Format: double
             * @description The pressure in Pa, corrected for the gas; `null` where no factor holds.
             */
            corrected_pa: number | null;
            /**
             * Format: int32
             * @description The instance or channel, 0 if there is only one.
             */
            instance: number;
            /**
             * Format: double
             * @description The end of the range in Pa, of a pressure below it (`underrange`) or above it (`overrange`).
             */
            limit_pa: number | null;
            /**
             * Format: double
             * @description The indicated pressure in Pa; `null` unless the quality is `valid`.
             */
            pa: number | null;
            principle: components["schemas"]["Principle"] | null;
            /** @description The quality. */
            quality: components["schemas"]["Quality"];
            /** @description The name under which it is recorded: that of the gauge, with the channel of a controller. */
            series: string;
        };
        /**
         * @description What a receiver is.
         * @enum {string}
         */
        ReceiverKind: "webhook" | "email";
        /** @description A point whose values are recorded. With another unit, or as another kind, it is another point: numbers in two units are never mixed. */
        RecordedPoint: {
            /** @description What the values are. */
            kind: components["schemas"]["PointKind"];
            /** @description The name of the point, unique for its slave. */
            name: string;
            /** @description The slave. */
            slave: string;
            /** @description The unit of the values; `null` without one. */
            unit: string | null;
        };
        /** @description The recorder. */
        RecorderView: {
            /** @description The damage that the last check has found, if it has found any. */
            damage: string | null;
            /** @description Why it does not write, if it does not. */
            error: string | null;
            /**
             * Format: int64
             * @description When the last check of the whole database ended, in milliseconds since 1970; `null` before the first one.
             */
            last_check_ms: number | null;
            /**
             * Format: int64
             * @description The time of the last write, in milliseconds since 1970.
             */
            last_write_ms: number | null;
            /**
             * Format: int64
             * @description Events that were dropped.
             */
            lost_events: number;
            /**
             * Format: int64
             * @description Samples that were dropped.
             */
            lost_samples: number;
        };
        /** @description An alarm that was not changed. */
        RefusedAlarm: {
            /** @description Its name. */
            name: string;
            /** @description The reason, in a sentence. */
            problem: string;
        };
        /** @description The effect of a remedy. */
        RemedyView: {
            /** @description The pressure after another day of pumping divided by that with the remedy. */
            divided_by: components["schemas"]["BoundsView"];
            remedy: ("close-leak" | "bake" | "larger-pump" | "better-pump") & Record<string, never>;
            /** @description The remedy in words. */
            text: string;
        };
        /** @description A group of samples beside the fit. */
        ResidualView: {
            /**
             * Format: double
             * @description The logarithm of measured by fitted pressure, in standard deviations.
             */
            deviations: number;
            /**
             * Format: double
             * @description The fitted pressure in Pa.
             */
            fitted_pa: number;
            /**
             * Format: double
             * @description The mean measured pressure in Pa.
             */
            measured_pa: number;
            /**
             * Format: double
             * @description Seconds after the start.
             */
            s: number;
        };
        /**
         * @description The cause of a pressure rise.
         * @enum {string}
         */
        RiseCause: "leak" | "outgassing" | "both" | "undistinguished" | "no-rise";
        /** @description The flows of a pressure rise. */
        RiseFlows: {
            /** @description The leak. */
            leak: components["schemas"]["FlowView"];
            /** @description The outgassing at the beginning. */
            outgassing: components["schemas"]["FlowView"];
        };
        /** @description A point of the fitted rise. */
        RisePoint: {
            /**
             * Format: double
             * @description The pressure in Pa.
             */
            pa: number;
            /**
             * Format: double
             * @description Seconds since the beginning.
             */
            s: number;
        };
        /** @description The probabilities of the shapes of a rise; they add up to 1. */
        RiseShapes: {
            /**
             * Format: double
             * @description A straight line and outgassing that falls with the time.
             */
            inverse_time: number;
            /**
             * Format: double
             * @description A straight line and outgassing that saturates.
             */
            saturating: number;
            /**
             * Format: double
             * @description A straight line.
             */
            straight: number;
        };
        /** @description A pressure rise, separated into leak and outgassing. */
        RiseView: {
            /**
             * Format: double
             * @description The accuracy of the gauge that the intervals contain, as a fraction; `null` if it was not given.
             */
            accuracy: number | null;
            /** @description The cause. */
            cause: components["schemas"]["RiseCause"];
            /** @description The best fit, at most 400 points. */
            fitted: components["schemas"]["RisePoint"][];
            flows: components["schemas"]["RiseFlows"] | null;
            /** @description The leak in Pa/s. */
            leak_pa_per_s: components["schemas"]["IntervalView"];
            /**
             * Format: double
             * @description The root mean square of the residuals divided by the noise: near 1 for a good fit.
             */
            misfit: number;
            /** @description The outgassing at the beginning in Pa/s. */
            outgassing_pa_per_s: components["schemas"]["IntervalView"];
            /**
             * Format: double
             * @description The time of pumping before the beginning in seconds; `null` if the database has no pump-down before it.
             */
            pumped_s: number | null;
            /** @description The number of fitted samples. */
            samples: number;
            /** @description The probabilities of the shapes. */
            shapes: components["schemas"]["RiseShapes"];
            /**
             * Format: double
             * @description The time constant of saturation in seconds; `null` unless that shape is the most probable one.
             */
            tau_s: number | null;
        };
        /** @description A risk. */
        Risk: {
            /** @description How large it is. */
            class: components["schemas"]["RiskClass"];
            /** @description A description, from the table where it has one. */
            description: string;
        };
        /**
         * @description How large a risk is.
         * @enum {string}
         */
        RiskClass: "harmless" | "volatile" | "stored-on-request" | "persistent" | "dangerous";
        /**
         * @description The role of a user. A role includes the permissions of all lower roles.
         * @enum {string}
         */
        Role: "viewer" | "operator" | "engineer";
        /** @description A view of all users: a filter of the overview, or a group of trends. */
        SavedView: {
            /** @description The group. */
            group: string | null;
            /** @description The location. */
            location: string | null;
            /** @description Its name. */
            name: string;
            /** @description Words that are searched in name, segment, device and labels. */
            search: string | null;
            /** @description The series of the trends: gauges, or channels of a controller. Empty for a filter. */
            series: string[];
            state: components["schemas"]["ViewState"] | null;
            /** @description The tag. */
            tag: string | null;
        };
        /** @description A segment with the stations on its bus. */
        Segment: {
            /**
             * Format: int32
             * @description Bits per second.
             */
            baud: number;
            /**
             * Format: double
             * @description The duration of a cycle, in milliseconds.
             */
            cycle_ms: number | null;
            /**
             * Format: int32
             * @description Telegrams that arrived damaged since the port was opened.
             */
            damaged_telegrams: number;
            /** @description The station only listens: it sends nothing, and offers no control. */
            listen_only: boolean;
            /**
             * Format: int32
             * @description The address of the master of this station; `null` if the station only listens.
             */
            master: number | null;
            /** @description Its name. */
            name: string;
            /** @description Its port. */
            port: string;
            /** @description Why it does not run, in a sentence. */
            problem: string | null;
            /** @description The state. */
            state: components["schemas"]["SegmentState"];
            /** @description The stations on the bus, by address. */
            stations: components["schemas"]["BusStation"][];
        };
        /**
         * @description The state of a segment.
         * @enum {string}
         */
        SegmentState: "waiting" | "listening" | "running";
        /** @description The session of a request. */
        Session: {
            /** @description Whether this station keeps the password of the user, who may change it here. */
            has_password: boolean;
            /** @description Whether the user has to log in, and has. */
            login: components["schemas"]["LoginState"];
            /**
             * @description The name of the user.
             * @example ada
             */
            name: string;
            /**
             * @description The name of the OpenID provider at which users may log in; `null` if there is none.
             * @example Keycloak
             */
            provider: string | null;
            /** @description The role of the user. */
            role: components["schemas"]["Role"];
            /** @description The value of the header `x-csrf-token` that every request other than GET and HEAD needs; empty before login. */
            token: string;
        };
        /** @description The gauges of an alarm about several, and the condition that `limit` of them must meet. */
        SeveralView: {
            /** @description The condition of each. */
            condition: components["schemas"]["LimitKind"];
            /**
             * Format: double
             * @description The limit of each.
             */
            limit: number | null;
            /** @description The measuring parts, by the names under which they are recorded. */
            series: string[];
            /** @description The unit of the limit. */
            unit: string | null;
        };
        /** @description Which alarms are shelved, why, and for how long. */
        Shelve: {
            /**
             * @description The names of 1 to 1000 alarms.
             * @example [
             *       "chamber: fault"
             *     ]
             */
            alarms: string[];
            /**
             * Format: int32
             * @description The time in minutes, 1 to 720.
             */
            minutes: number;
            /**
             * @description The reason, in one line of 1 to 500 characters.
             * @example the lock is vented
             */
            reason: string;
        };
        /** @description The state of the station at one moment. */
        Snapshot: {
            /** @description The number of alarms by state and priority. */
            alarms: components["schemas"]["AlarmOverview"];
            /** @description The user with control authority, and a request for it. */
            control_authority: components["schemas"]["ControlAuthorityView"];
            /**
             * Format: int64
             * @description Changes when `/api/directory` changes.
             */
            directory_revision: number;
            /** @description The names of the gauges in the order of the station's file. */
            gauge_order: string[];
            /**
             * @description Its gauges with their readings, by name: pressures with five digits, ages in whole seconds, without `read_ms`, and with
             *     `parameters` of slaves only, which are their points.
             */
            gauges: {
                [key: string]: components["schemas"]["Gauge"];
            };
            /** @description The states of the parts of the plant. */
            plant: components["schemas"]["LivePlant"];
            /** @description The gauges whose parameters are being read. */
            read_progress: components["schemas"]["ReadProgress"][];
            /** @description Its segments, by name. */
            segments: {
                [key: string]: components["schemas"]["Segment"];
            };
            /**
             * @description All alarms that are neither normal nor shelved nor out of service nor suppressed, by name. The 50 most urgent have a present value, with
             *     five digits; `/api/alarms` has the others.
             */
            standing_alarms: {
                [key: string]: components["schemas"]["AlarmView"];
            };
            /** @description The station. */
            station: components["schemas"]["Station"];
        };
        /** @description An effective pumping speed. */
        SpeedView: {
            /** @description The speed in m³/s. */
            m3_per_s: components["schemas"]["ParameterView"];
            /**
             * Format: double
             * @description The pressure in Pa, as indicated.
             */
            pa: number;
        };
        /** @description A change of the indication that looks like helium at a leak. */
        SprayView: {
            /** @description The change of the indication after many time constants in Pa; below zero if it falls. */
            change_pa: components["schemas"]["BoundsView"];
            /**
             * Format: int64
             * @description When it went, in milliseconds since 1970.
             */
            end_ms: number;
            leak_pa_m3_per_s: components["schemas"]["BoundsView"] | null;
            /**
             * Format: int64
             * @description When the gas came, in milliseconds since 1970.
             */
            start_ms: number;
            /**
             * @description What it looks like, in words.
             * @example 2026-11-21 14:05:00 UTC, for 90.0 s: the indication falls by 5.4e-8 mbar (5.2e-8 to 5.6e-8), 27 % of it
             */
            text: string;
            /** @description The time constant of change and return in seconds: volume by pumping speed. */
            time_constant_s: components["schemas"]["BoundsView"];
        };
        /** @description The station. */
        Station: {
            /** @description What the archive does not have of the station, in a sentence: it does not answer, or has put batches aside. */
            archive_problem: string | null;
            /** @description The name. */
            name: string;
            /**
             * Format: int64
             * @description The time of its clock, in milliseconds since 1970.
             */
            now_ms: number;
            /** @description The recorder. */
            recorder: components["schemas"]["RecorderView"];
            /**
             * Format: int64
             * @description When it was started, in milliseconds since 1970.
             */
            started_ms: number;
            /** @description The parts that cannot run, for example a gateway whose address another program has; the station tries again. */
            stopped_parts: components["schemas"]["StoppedPart"][];
            /** @description The version of the program. */
            version: string;
        };
        /**
         * @description The subject of an event.
         * @enum {string}
         */
        StationEventKind: "station" | "bus" | "gauge" | "command" | "note" | "access" | "alarm" | "pump-down";
        /** @description A station of the live list. */
        StationReport: {
            /**
             * Format: int32
             * @description Its address.
             */
            address: number;
            configuration_origin: components["schemas"]["Origin"] | null;
            /** @description The devices with its Ident_Number, or the one that the file names; empty if it is not known. */
            devices: string[];
            /** @description What its last diagnosis reports. */
            diagnosis: string[];
            /** @description Its earlier diagnoses, newest first. */
            diagnosis_history: components["schemas"]["DiagnosisReport"][];
            /** @description Its Ident_Number, if a telegram showed it: `0x08E6`. */
            ident: string | null;
            /** @description The time between two Data_Exchange requests to it. */
            interval: components["schemas"]["Distribution"];
            /** @description Counters of the last minute. */
            last_minute: components["schemas"]["Counts"];
            /**
             * Format: int32
             * @description The longest sequence of repetitions of one request.
             */
            longest_sequence: number;
            /**
             * Format: int32
             * @description The address of its owner, if a diagnosis showed it.
             */
            owner: number | null;
            /**
             * Format: double
             * @description Repetitions of the last minute in percent of its requests.
             */
            repeated_percent: number;
            /** @description Its state. */
            state: components["schemas"]["StationState"];
            /** @description Counters since the beginning. */
            total: components["schemas"]["Counts"];
            /** @description The unit of its pressures. */
            unit: string | null;
            unit_origin: components["schemas"]["Origin"] | null;
            /** @description What the traffic has not shown. */
            unknown: string[];
        };
        /**
         * @description The state of a station in the live list.
         * @enum {string}
         */
        StationState: "master" | "exchanging" | "missing" | "not-configured" | "no-master" | "not-addressed";
        /** @description A part of the station that cannot run. */
        StoppedPart: {
            /** @description Its name: that of a gateway. */
            name: string;
            /** @description Why it does not run, in a sentence. */
            problem: string;
        };
        /** @description A sentence about something that happens in the plant. */
        StorySentence: {
            /**
             * Format: int64
             * @description When, in milliseconds since 1970.
             */
            at_ms: number;
            /** @description The sentence. */
            text: string;
        };
        /** @description Why an alarm is shelved, out of service or suppressed. */
        SuppressionView: {
            /**
             * Format: int64
             * @description When.
             */
            at_ms: number;
            /** @description The reason; of a plant state with its name before it. */
            reason: string;
            /**
             * Format: int64
             * @description When it ends by itself; `null` if a user must return it to service.
             */
            until_ms: number | null;
            /** @description The user who shelved it, took it out of service, or declared the plant state that suppresses it. */
            user: string;
        };
        /** @description Why an alarm is taken out of service, and for how long. */
        TakeOutOfService: {
            /**
             * Format: int32
             * @description The time in minutes, 1 to 44640; without it until a user returns the alarm to service.
             */
            minutes?: number | null;
            /**
             * @description The reason, in one line of 1 to 500 characters.
             * @example the gauge is being replaced
             */
            reason: string;
        };
        /** @description A period of ten minutes. */
        TenMinutes: {
            /**
             * Format: int64
             * @description Its beginning, in milliseconds since 1970.
             */
            from_ms: number;
            /**
             * Format: int64
             * @description The alarms that were raised in it.
             */
            raised: number;
        };
        /** @description A time with its 95 % interval. */
        TimeView: {
            /**
             * Format: double
             * @description The upper bound in seconds; `null` if the target may never be reached.
             */
            high: number | null;
            /**
             * Format: double
             * @description The lower bound in seconds.
             */
            low: number;
            /**
             * Format: double
             * @description The best value in seconds; `null` if the target is more likely never reached.
             */
            mean: number | null;
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
        /** @description The alarms that are unshelved. */
        Unshelve: {
            /**
             * @description The names of 1 to 1000 alarms.
             * @example [
             *       "chamber: fault"
             *     ]
             */
            alarms: string[];
        };
        /** @description The usual time to a pressure. */
        UsualView: {
            /**
             * Format: double
             * @description A shorter time deviates.
             */
            least_s: number;
            /**
             * Format: double
             * @description A longer time deviates.
             */
            most_s: number;
            /** @description The number of pump-downs; 1 with a chosen reference. */
            runs: number;
            /**
             * Format: double
             * @description The median in seconds.
             */
            s: number;
        };
        /**
         * @description The state of a gauge that a view chooses.
         * @enum {string}
         */
        ViewState: "problems" | "alarms" | "fault" | "no-data" | "calibration-overdue";
        /** @description A parameter that the station reads from time to time: emission, degas, trip points, relays. A point of a slave is one too. */
        WatchedParameter: {
            /** @description The manual's name; of a point its place in the inputs. */
            name: string;
            /**
             * Format: double
             * @description The value in this unit; `null` if it was not read, the gauge did not answer the last time, or a state was read more than 60 s ago.
             */
            number: number | null;
            /** @description The quality: `valid`; `stale` without a value; `fault` for a point whose number is bad. */
            quality: components["schemas"]["Quality"];
            /**
             * Format: int64
             * @description When it was read, in milliseconds since 1970.
             */
            read_ms: number | null;
            /** @description The name by which it is read and written: `trip-point.1/high-trip-point`; of a point its name. */
            target: string;
            /** @description The value in the words of the manual, or of the station's file for a point; of a stale point why its record was not read. */
            text: string;
            /**
             * @description The unit of its number: `Pa` for a pressure, `%` for a percentage, `null` for a number or a code without a unit; of a point the
             *     unit in the station's file.
             */
            unit: string | null;
        };
        /** @description The delivery status of a webhook. */
        WebhookView: {
            /** @description Scheme and host of its URL, or of the mail server; the rest often is a secret. */
            at: string;
            /**
             * Format: int64
             * @description Notifications delivered since the station started.
             */
            delivered: number;
            /**
             * Format: int64
             * @description When the last notification was delivered, in milliseconds since 1970.
             */
            delivered_ms: number | null;
            /**
             * Format: int64
             * @description Since when the delivery fails, in milliseconds since 1970.
             */
            failing_since_ms: number | null;
            /**
             * Format: int64
             * @description Notifications given up since the station started.
             */
            given_up: number;
            /** @description Where its notifications go. */
            kind: components["schemas"]["ReceiverKind"];
            /** @description Its name. */
            name: string;
            /** @description The reason why the next notification is not delivered; the station tries again. */
            problem: string | null;
            /** @description Notifications that wait for delivery. */
            waiting: number;
        };
        /** @description How a parameter is written. */
        WriteInfo: {
            /** @description The allowed values, if only some are allowed. */
            allowed_values: string[];
            /** @description Why the station never writes it. */
            blocked_reason: string | null;
            /** @description A description of the expected value, with its unit. */
            expects: string;
            /** @description The risk. */
            risk: components["schemas"]["Risk"];
            /** @description The role it needs. */
            role: components["schemas"]["Role"];
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
    alarms: {
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
                    "application/json": components["schemas"]["AlarmView"][];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    acknowledge_all: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["AcknowledgeAll"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["AcknowledgeAllResult"];
                };
            };
            /** @description The body is malformed, or has no or too many alarms */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The role operator is needed */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    history: {
        parameters: {
            query: {
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
                /** @description The most entries of the answer, 1 to 10000. */
                limit?: number;
                /** @description The name of an alarm; without it the history of all alarms. */
                alarm?: string;
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
                    "application/json": components["schemas"]["AlarmHistoryEntry"][];
                };
            };
            /** @description A parameter is missing or out of range */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The database cannot be read */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    performance: {
        parameters: {
            query: {
                /**
                 * @description The beginning, in milliseconds since 1970.
                 * @example 1767225600000
                 */
                from: number;
                /**
                 * @description The end, in milliseconds since 1970.
                 * @example 1767312000000
                 */
                to: number;
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
                    "application/json": components["schemas"]["AlarmPerformance"];
                };
            };
            /** @description A parameter is missing or out of range */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The database cannot be read */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    shelve: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Shelve"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ChangedAlarms"];
                };
            };
            /** @description The body is malformed, or something in it is out of range */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The role operator is needed */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    unshelve: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Unshelve"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ChangedAlarms"];
                };
            };
            /** @description The body is malformed, or has no or too many alarms */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The role operator is needed */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
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
                 * @description The name of the alarm
                 * @example chamber: fault
                 */
                name: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Acknowledge"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["AlarmView"];
                };
            };
            /** @description The body is malformed */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The role operator is needed */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no alarm of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The alarm was raised again since, or is acknowledged already */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The alarm is acknowledged, but the database cannot be written */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    out_of_service: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /**
                 * @description The name of the alarm
                 * @example chamber: fault
                 */
                name: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["TakeOutOfService"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["AlarmView"];
                };
            };
            /** @description The body is malformed, or the reason or the time is out of range */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The role engineer is needed */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no alarm of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The alarm is already out of service */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The alarm is out of service, but the database cannot be written */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    return_to_service: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /**
                 * @description The name of the alarm
                 * @example chamber: fault
                 */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["AlarmView"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The role engineer is needed */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no alarm of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The alarm is in service */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The alarm is in service, but the database cannot be written */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    settings: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /**
                 * @description The name of the alarm
                 * @example chamber too high
                 */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["AlarmSettings"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no alarm of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The alarm is a default alarm, or the station has no file */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    change: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /**
                 * @description The name of the alarm
                 * @example chamber too high
                 */
                name: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["ChangeSettings"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["AlarmView"];
                };
            };
            /** @description The body is malformed, or the station's file would be wrong */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The role engineer is needed */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no alarm of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The settings or the file have changed since, the alarm is a default alarm, or the station has no file */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The file cannot be written, or the database cannot */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    disarm: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The identifier of the armed command */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The command is disarmed */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Another user armed the command */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no armed command with this identifier */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The command is being executed or has expired */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ConflictView"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    execute: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The identifier of the armed command */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ExecutedView"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The role of the user does not permit it */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no armed command with this identifier */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The command has expired, the user has no control authority, a condition or the value has changed, or the gauge refused */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ConflictView"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The audit trail cannot be written */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    audit: {
        parameters: {
            query?: {
                /**
                 * @description The beginning, in milliseconds since 1970; without it from the first entry.
                 * @example 0
                 */
                from?: number;
                /**
                 * @description The end, in milliseconds since 1970; without it to the last entry.
                 * @example 4102444800000
                 */
                to?: number;
                /** @description Only entries about this gauge. */
                gauge?: string;
                /** @description Only entries of this user. */
                user?: string;
                /** @description The most entries of the answer, 1 to 100000. The default is 200, as CSV 100000. */
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
                    "application/json": components["schemas"]["AuditEntry"][];
                };
            };
            /** @description A parameter is out of range */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description No gauge and no entry has this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The database cannot be read */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    csv: {
        parameters: {
            query?: {
                /**
                 * @description The beginning, in milliseconds since 1970; without it from the first entry.
                 * @example 0
                 */
                from?: number;
                /**
                 * @description The end, in milliseconds since 1970; without it to the last entry.
                 * @example 4102444800000
                 */
                to?: number;
                /** @description Only entries about this gauge. */
                gauge?: string;
                /** @description Only entries of this user. */
                user?: string;
                /** @description The most entries of the answer, 1 to 100000. The default is 200, as CSV 100000. */
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
                    "text/csv": string;
                };
            };
            /** @description A parameter is out of range */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description No gauge and no entry has this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The database cannot be read */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    backup: {
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
                    "application/json": components["schemas"]["BackupView"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The role engineer is needed */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Another copy is being made or downloaded */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The database cannot be read, or the disk has no room for the copy */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    download: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /**
                 * @description The name of the copy
                 * @example 0
                 */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/vnd.sqlite3": string;
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The role engineer is needed */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no such copy, or no longer */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    authority: {
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
                    "application/json": components["schemas"]["ControlAuthorityView"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    grant: {
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
                    "application/json": components["schemas"]["ControlAuthorityView"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The role operator is needed */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user does not have control authority, or there is no request */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ConflictView"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    release: {
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
                    "application/json": components["schemas"]["ControlAuthorityView"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The role operator is needed */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user does not have control authority */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ConflictView"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    request: {
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
                    "application/json": components["schemas"]["ControlAuthorityView"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The role operator is needed */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Another user has requested it already */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ConflictView"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    take_over: {
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
                    "application/json": components["schemas"]["ControlAuthorityView"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The role operator is needed */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The holder still has time to answer the request */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ConflictView"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    defaults: {
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
                    "application/json": components["schemas"]["DefaultAlarmView"][];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    change_default: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /**
                 * @description The name of the default alarm in the table `[alarms]`
                 * @example stale
                 */
                name: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["ChangeDefaultSettings"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["DefaultAlarmSettings"];
                };
            };
            /** @description The body is malformed, or the station's file would be wrong */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The role engineer is needed */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no default alarm of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The settings or the file have changed since, or the station has no file */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The file cannot be written, or the database cannot */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    directory: {
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
                    "application/json": components["schemas"]["Directory"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    events: {
        parameters: {
            query: {
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
                    "application/json": components["schemas"]["Event"][];
                };
            };
            /** @description A parameter is missing or out of range */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The database cannot be read */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    export: {
        parameters: {
            query: {
                /**
                 * @description The name of a series; `series` may be repeated. Without it the export has all series. A value that is not the name of a
                 *     series is split at its commas.
                 */
                series?: string[];
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
                    "text/csv": string;
                };
            };
            /** @description A parameter is missing or malformed */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no series of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The database cannot be read */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    export_parquet: {
        parameters: {
            query: {
                /**
                 * @description The name of a series; `series` may be repeated. Without it the export has all series. A value that is not the name of a
                 *     series is split at its commas.
                 */
                series?: string[];
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
                    "application/vnd.apache.parquet": string;
                };
            };
            /** @description A parameter is missing or malformed */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no series of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description This program was built without Parquet */
            501: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The database cannot be read */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    gateways: {
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
                    "application/json": components["schemas"]["GatewayView"][];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    gauges: {
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
                    "application/json": components["schemas"]["LabelledGauge"][];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    gauge: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /**
                 * @description The name of the gauge
                 * @example chamber
                 */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["LabelledGauge"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no gauge of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    arm: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /**
                 * @description The name of the gauge
                 * @example chamber
                 */
                name: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["OperationRequest"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ArmedCommandView"];
                };
            };
            /** @description The gauge has no such command or parameter, or does not accept the value */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The role of the user does not permit it */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no gauge of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no control authority, a condition is not met, or the gauge does not answer */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ConflictView"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    blocks: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /**
                 * @description The name of the gauge
                 * @example chamber
                 */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Block"][];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no gauge of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The gauge does not answer */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The segment is busy */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    commands: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /**
                 * @description The name of the gauge
                 * @example chamber
                 */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Command"][];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no gauge of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    identify: {
        parameters: {
            query: {
                /**
                 * @description The name of the series: that of a gauge, or `gauge.N` for channel N of a controller.
                 * @example chamber
                 */
                series: string;
                /**
                 * @description The start of the pump-down, in milliseconds since 1970.
                 * @example 0
                 */
                from: number;
                /**
                 * @description The end of the time range, in milliseconds since 1970.
                 * @example 4102444800000
                 */
                to: number;
                /** @description When the valve to the pump was closed, in milliseconds since 1970. Without it the beginning of the largest rise. */
                closed?: number;
                /** @description When the valve was opened again, in milliseconds since 1970. Without it the end of that rise. */
                opened?: number;
                /**
                 * @description The volume in m³. Without it a dose is needed.
                 * @example 0.1
                 */
                volume_m3?: number;
                /** @description A dose of gas in Pa m³, let in while the valve was closed, from which the volume follows. */
                dose_pa_m3?: number;
                /** @description When the dose was let in, in milliseconds since 1970. */
                dose_at?: number;
                /**
                 * @description How the indication depends on the gas, `none` unless given. The correction takes outgassing as water and a leak as air.
                 * @example none
                 */
                gauge?: "none" | "ionisation" | "conduction";
                /**
                 * @description The accuracy of the gauge as a fraction of the reading, as its manual states it: 0.15 for ±15 %. It widens leak and
                 *     outgassing, and the volume from a dose.
                 * @example 0.15
                 */
                accuracy?: number;
                /** @description A pressure in Pa whose time is predicted. */
                target_pa?: number;
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
                    "application/json": components["schemas"]["PlantView"];
                };
            };
            /** @description A parameter is out of range, or the samples cannot be fitted */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no series of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The database cannot be read, another fit runs, or the fit takes too long */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
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
                    "text/event-stream": components["schemas"]["LiveEvent"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    login: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Login"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Session"];
                };
            };
            /** @description The body is malformed */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The name or the password is wrong */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The station has no users */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description Too many logins at the same time */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    logout: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The session has ended, and the browser may end that at the provider */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ProviderAddress"];
                };
            };
            /** @description The session has ended */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    make: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["NewNote"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Event"];
                };
            };
            /** @description The body is malformed, or something in it is out of range */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The role operator is needed */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no gauge of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The database cannot be written: the note is not stored, unless the answer says that the disk did not answer in time */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    openid_begin: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["OpenIdBegin"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ProviderAddress"];
                };
            };
            /** @description The body is malformed */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The page has another address than the provider sends browsers to */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The station has no OpenID provider */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The provider does not answer, or too many users log in at the same time */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    openid_login: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["OpenIdLogin"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Session"];
                };
            };
            /** @description The body is malformed */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The login is refused: it began in another browser, the provider refuses it, or the user has no role here */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The station has no OpenID provider */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The provider does not answer, or too many users log in at the same time */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    password: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["NewPassword"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Session"];
                };
            };
            /** @description The new password is refused */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The current password is wrong, or an OpenID provider keeps it */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The station has no users */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The password cannot be stored */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    plant: {
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
                    "application/json": components["schemas"]["PlantPicture"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    plant_states: {
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
                    "application/json": components["schemas"]["PlantStateView"][];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    declare: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /**
                 * @description The name of the plant state
                 * @example Vented
                 */
                name: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Declare"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["PlantStateView"];
                };
            };
            /** @description The body is malformed, or the reason or the time is out of range */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The role of the plant state is needed */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no plant state of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The plant state is declared already */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The plant state is declared, but the database cannot be written */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    end: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /**
                 * @description The name of the plant state
                 * @example Vented
                 */
                name: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["End"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["PlantStateView"];
                };
            };
            /** @description The body is malformed, or the reason is out of range */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The role operator is needed */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no plant state of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The plant state is not declared */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The plant state has ended, but the database cannot be written */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    extend: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /**
                 * @description The name of the plant state
                 * @example Vented
                 */
                name: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Declare"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["PlantStateView"];
                };
            };
            /** @description The body is malformed, or the reason or the time is out of range */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The role of the plant state is needed */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no plant state of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The plant state is not declared, or has a later end already */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The plant state is extended, but the database cannot be written */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    point_trend: {
        parameters: {
            query: {
                /**
                 * @description The name of the slave.
                 * @example turbo
                 */
                slave: string;
                /**
                 * @description The name of the point.
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
            /** @description A parameter is missing or out of range */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no such point */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The database cannot be read */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    points: {
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
                    "application/json": components["schemas"]["DescribedPoint"][];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The database cannot be read */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    export_points: {
        parameters: {
            query: {
                /** @description The name of a slave. Without it the export has the points of all slaves. */
                slave?: string;
                /** @description The name of a point. Without it the export has all points. */
                point?: string;
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
                    "text/csv": string;
                };
            };
            /** @description A parameter is missing or malformed */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The database cannot be read */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    export_points_parquet: {
        parameters: {
            query: {
                /** @description The name of a slave. Without it the export has the points of all slaves. */
                slave?: string;
                /** @description The name of a point. Without it the export has all points. */
                point?: string;
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
                    "application/vnd.apache.parquet": string;
                };
            };
            /** @description A parameter is missing or malformed */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description This program was built without Parquet */
            501: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The database cannot be read */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    pump_downs: {
        parameters: {
            query: {
                /**
                 * @description The name of the series: that of a gauge, or `gauge.N` for channel N of a controller.
                 * @example chamber
                 */
                series: string;
                /**
                 * @description The beginning, in milliseconds since 1970. Pump-downs before it are not usual ones.
                 * @example 0
                 */
                from: number;
                /**
                 * @description The end, in milliseconds since 1970.
                 * @example 4102444800000
                 */
                to: number;
                /** @description The most pump-downs of the answer, 1 to 50. */
                limit?: number;
                /**
                 * @description The beginning of the pump-down with which all others are compared, in milliseconds since 1970; without it each one is compared
                 *     with the last ten before it.
                 */
                reference?: number;
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
                    "application/json": components["schemas"]["PumpDowns"];
                };
            };
            /** @description A parameter is out of range, or no pump-down begins at `reference` */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no series of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The database cannot be read */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    report: {
        parameters: {
            query: {
                /**
                 * @description The name of the series: that of a gauge, or `gauge.N` for channel N of a controller.
                 * @example chamber
                 */
                series: string;
                /**
                 * @description The start of the pump-down, in milliseconds since 1970.
                 * @example 0
                 */
                from: number;
                /**
                 * @description The end, in milliseconds since 1970; at most a year after the start.
                 * @example 31000000000
                 */
                to: number;
                /**
                 * @description The volume in m³. With it the report has pumping speeds, flows and the numbers of the plant.
                 * @example 0.1
                 */
                volume_m3?: number;
                /**
                 * @description The accuracy of the gauge as a fraction of the reading: 0.15 for ±15 %.
                 * @example 0.15
                 */
                accuracy?: number;
                /**
                 * @description The unit of pressures: mbar, Pa, hPa, Torr or micron; mbar unless given.
                 * @example mbar
                 */
                unit?: string;
                /** @description The time zone of the page by its IANA name, for example `Europe/Berlin`; UTC unless given. */
                zone?: string;
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
                    "text/html": string;
                };
            };
            /** @description A parameter is out of range */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no series of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The database cannot be read, or another fit runs */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    rise: {
        parameters: {
            query: {
                /**
                 * @description The name of the series: that of a gauge, or `gauge.N` for channel N of a controller.
                 * @example chamber
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
                /**
                 * @description The volume in m³. With it the answer has flows in Pa m³/s.
                 * @example 0.1
                 */
                volume_m3?: number;
                /**
                 * @description How the indication depends on the gas, `none` unless given. The correction takes outgassing as water and a leak as air.
                 * @example none
                 */
                gauge?: "none" | "ionisation" | "conduction";
                /**
                 * @description The accuracy of the gauge as a fraction of the reading, as its manual states it: 0.15 for ±15 %. Without it the intervals
                 *     do not contain the uncertainty of the gauge.
                 * @example 0.15
                 */
                accuracy?: number;
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
                    "application/json": components["schemas"]["RiseView"];
                };
            };
            /** @description A parameter is out of range, or the time range has too few samples */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no series of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The database cannot be read */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    segments: {
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
                    "application/json": components["schemas"]["Segment"][];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    bus: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /**
                 * @description The name of the segment
                 * @example hall
                 */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["BusReport"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no segment of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    captures: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /**
                 * @description The name of the segment
                 * @example hall
                 */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["CaptureView"][];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no segment of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    trigger: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /**
                 * @description The name of the segment
                 * @example hall
                 */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The capture is listed when it is complete */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no segment of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body does not arrive in time */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is longer than 64 KiB */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is not JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    capture: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /**
                 * @description The name of the segment
                 * @example hall
                 */
                name: string;
                /**
                 * @description The name of the capture
                 * @example 1700000000-0.pcapng
                 */
                file: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/x-pcapng": number[];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no such capture */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    session: {
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
                    "application/json": components["schemas"]["Session"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    station: {
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
                    "application/json": components["schemas"]["Station"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    trend: {
        parameters: {
            query: {
                /**
                 * @description The name of the series: that of a gauge, or `gauge.N` for channel N of a controller.
                 * @example chamber
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
            /** @description A parameter is missing or out of range */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description There is no series of this name */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The database cannot be read */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    webhooks: {
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
                    "application/json": components["schemas"]["WebhookView"][];
                };
            };
            /** @description The user has not logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The user has no permission, or the request comes from a foreign page */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The request is meant for another computer */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The client is above a rate limit; the header Retry-After gives the time to wait in seconds */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
            /** @description The database cannot be read */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
}
