// Generated from openapi.json by `npm run generate`. Do not edit.

export interface paths {
    "/api/alarms": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** All alarms, in the order of the file, then those that there are by themselves. */
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
        /** Somebody knows of several alarms that they have seen. Each is acknowledged or refused for itself. */
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
        /** What happened to alarms, the latest first. */
        get: operations["history"];
        put?: never;
        post?: never;
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
        /** Somebody knows of an alarm: of the occurrence they have seen, and of no later one. It is on the disk when this is answered. */
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
        /** Takes an alarm out of service, with a reason, for a time or until somebody puts it back. */
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
        /** Puts an alarm back into service. If its condition holds, it is raised at once. */
        post: operations["return_to_service"];
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
        /** Who did what, the latest first. */
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
        /** The same as a table, the earliest first: times are ISO 8601 in UTC. */
        get: operations["csv"];
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
        /** What happened, the latest first. */
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
        /** What was recorded, as a table: time (ISO 8601, UTC), series, pressure in Pa, quality. */
        get: operations["export"];
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
        /** Gauges, and what they show. */
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
        /** One gauge, and what it shows. */
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
        /** The first step: the gauge is asked, and if all conditions hold it is armed for 30 seconds. Needs the mastership. */
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
        /** The blocks of a gauge with what their parameters show. They are read from the gauge now, beside its cyclic data. */
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
        /** The commands of a gauge with what they ask for and risk. The gauge is not asked. */
        get: operations["commands"];
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
         * Gauges and segments four times a second, as server-sent events named `moment`. Whoever is slow misses moments. It ends with
         *     the session it was asked for in.
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
        /** Begins a session. The same answer at the same time to a wrong password and to a name that there is not. */
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
        /** Ends the session. */
        post: operations["logout"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/mastership": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Who may act now. */
        get: operations["mastership"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/mastership/ask": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Somebody wants the mastership: if it is free they have it, else its holder is told. */
        post: operations["ask"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/mastership/grant": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Its holder gives the mastership to who asked. */
        post: operations["grant"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/mastership/release": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Its holder gives the mastership back. */
        post: operations["release"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/mastership/take-over": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Somebody takes the mastership from its holder: an engineer at any time, an operator 60 s after asking without a reaction. */
        post: operations["take_over"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/orders/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        post?: never;
        /** What was armed is not armed any more. */
        delete: operations["disarm"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/orders/{id}/fire": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** The second step: what was armed is done, once, if everything is as it was then. Needs the mastership. */
        post: operations["fire"];
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
        /** Changes the password of whoever asks; their other sessions end. */
        post: operations["password"];
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
        /** A rise of pressure after a valve was closed, told apart into a leak and outgassing. */
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
        /** Segments, and who is on them. */
        get: operations["segments"];
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
        /** Who asks. */
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
        /** The station and its recorder. */
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
        /** What was recorded of a series, drawn for so many pixels. */
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
        /** Who is told of alarms, and how that goes. */
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
        /** @description What must be known about alarms at a moment. */
        ActiveAlarms: {
            /** @description Of high priority. */
            high: components["schemas"]["Count"];
            /** @description All that are neither normal nor out of service, the most urgent first; of very many only the first. */
            list: components["schemas"]["Alarm"][];
            /** @description Of low priority. */
            low: components["schemas"]["Count"];
            /** @description Of medium priority. */
            medium: components["schemas"]["Count"];
            /** @description How many there are beyond the list. */
            more: number;
            /** @description How many are out of service. */
            out_of_service: number;
            /** @description Why what is told here may be wrong: nobody has looked for long, or it cannot be written. */
            trouble: string | null;
        };
        /** @description An alarm. */
        Alarm: {
            /** @description Who acknowledged it. */
            acknowledged_by: string | null;
            /**
             * Format: int64
             * @description When.
             */
            acknowledged_ms: number | null;
            /**
             * @description What is watched: `above`, `below`, `rise`, `blind`, `fault`, `stale`, `down`, `damage`, `unrecorded`.
             * @enum {string}
             */
            condition: "above" | "below" | "rise" | "blind" | "fault" | "stale" | "down" | "damage" | "unrecorded";
            /** @description The gauge. */
            gauge: string | null;
            /**
             * Format: double
             * @description The limit.
             */
            limit: number | null;
            /** @description What is to be done, as the file says. */
            message: string | null;
            /** @description Its name. */
            name: string;
            /**
             * Format: int64
             * @description Which time it was raised, to be given when it is acknowledged; 0 if it never was.
             */
            occurrence: number;
            out_of_service: components["schemas"]["OutOfService"] | null;
            /** @description How soon somebody must do something. */
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
             * @description Where it is over.
             */
            reset: number | null;
            /** @description The segment, if the alarm is about one. */
            segment: string | null;
            /** @description The measuring part, by the name under which it is recorded. */
            series: string | null;
            /**
             * Format: int64
             * @description Since when it stands there; nothing if nothing ever became of it.
             */
            since_ms: number | null;
            /** @description Where it stands. */
            state: components["schemas"]["State"];
            /** @description What was seen when it was raised, in a sentence. */
            text: string;
            /** @description What values and limits are counted in. */
            unit: string | null;
            /**
             * Format: double
             * @description The value now.
             */
            value: number | null;
        };
        /** @description Something that is armed. */
        Armed: {
            /** @description What it is to be. */
            after: string;
            /** @description What it is now; nothing if it cannot be read. */
            before: string | null;
            /** @description All conditions; all hold. */
            conditions: components["schemas"]["Held"][];
            /** @description The gauge. */
            gauge: string;
            /** @description Whether it is a command. */
            is_command: boolean;
            /**
             * Format: int64
             * @description How much longer it is armed, in milliseconds.
             */
            left_ms: number;
            /** @description The manual's name and numbers. */
            manual: string;
            /** @description The octets that are sent. */
            octets: string;
            /** @description By what it is fired. */
            order: string;
            /** @description What it risks. */
            risk: components["schemas"]["Risk"];
            /** @description The command or the parameter. */
            target: string;
        };
        /** @description A row of the audit trail. */
        Audited: {
            /**
             * Format: int32
             * @description Its address on the bus.
             */
            address: number | null;
            /** @description What it was to be; of an outcome, what was read back. */
            after: string | null;
            /**
             * Format: int64
             * @description When, in milliseconds since 1970.
             */
            at_ms: number;
            /** @description What it was. */
            before: string | null;
            /** @description The gauge. */
            gauge: string | null;
            /**
             * Format: int64
             * @description Its number, rising.
             */
            id: number;
            /**
             * Format: int64
             * @description The row whose outcome this is.
             */
            of: number | null;
            /** @description The order. */
            order: string | null;
            /** @description What came of it. */
            outcome: string | null;
            /** @description From which address. */
            peer: string | null;
            /** @description Their role then. */
            role: string;
            /** @description Its segment. */
            segment: string | null;
            /** @description The manual's name and numbers, or the alarm. */
            target: string | null;
            /**
             * @description `fired` before it is sent, `outcome` after it, `refused` when a condition did not hold, `disarmed`, `mastership`; of an alarm
             *     `acknowledged`, `taken-out-of-service`, `returned-to-service`.
             * @enum {string}
             */
            what: "fired" | "outcome" | "refused" | "disarmed" | "mastership" | "acknowledged" | "taken-out-of-service" | "returned-to-service";
            /** @description Who. */
            who: string;
        };
        /** @description A block of a gauge with its parameters. */
        Block: {
            /** @description The manual's name of the block. */
            name: string;
            /** @description Its parameters. */
            parameters: components["schemas"]["Parameter"][];
        };
        /**
         * @description How much something risks.
         * @enum {string}
         */
        Class: "harmless" | "volatile" | "on-request" | "kept" | "dangerous";
        /** @description A command of a gauge. */
        Command: {
            /** @description Why nobody may from here. */
            barred: string | null;
            /** @description By what it is armed: `ba.degas-on`. */
            command: string;
            /** @description What must be the case. */
            conditions: string[];
            /** @description The manual's name of the parameter by which it is sent. */
            name: string;
            /** @description Its slot and index. */
            numbers: string;
            /** @description What it risks. */
            risk: components["schemas"]["Risk"];
            /** @description Who may. */
            role: components["schemas"]["Role"];
        };
        /** @description How many alarms of a priority there are. */
        Count: {
            /** @description Whose condition holds. */
            active: number;
            /** @description That nobody has acknowledged, whether their condition holds or not any more. */
            unacknowledged: number;
        };
        /**
         * @description How one comes in here.
         * @enum {string}
         */
        DoorState: "open" | "in" | "out";
        /** @description A line of the history. */
        Event: {
            /** @description The alarm. */
            alarm: string;
            /**
             * Format: int64
             * @description When.
             */
            at_ms: number;
            /**
             * Format: int64
             * @description Which time it was raised.
             */
            occurrence: number;
            /**
             * @description The priority it had.
             * @enum {string}
             */
            priority: "low" | "medium" | "high";
            /**
             * @description Where it stood then.
             * @enum {string}
             */
            state: "normal" | "unacknowledged" | "acknowledged" | "returned" | "out-of-service";
            /** @description The gauge or segment. */
            subject: string | null;
            /** @description A sentence. */
            text: string;
            /** @description What it is counted in. */
            unit: string | null;
            /**
             * Format: double
             * @description The value at that time.
             */
            value: number | null;
            /**
             * @description What happened: `raised`, `returned`, `acknowledged`, `taken-out-of-service`, `returned-to-service`, `removed`.
             * @enum {string}
             */
            what: "raised" | "returned" | "acknowledged" | "taken-out-of-service" | "returned-to-service" | "removed";
            /** @description Who did it; nothing if it came by itself. */
            who: string | null;
        };
        /** @description A gauge. */
        Gauge: {
            /**
             * Format: int32
             * @description Its address.
             */
            address: number;
            /**
             * Format: int64
             * @description How old the readings are, in milliseconds; nothing if there never was one.
             */
            age_ms: number | null;
            /** @description What it is: `bcg450`. */
            device: string;
            /** @description What it reports beside the pressure, in words. */
            exceptions: string[];
            /** @description The gas its readings are corrected for beside the indicated ones. */
            gas: string;
            /** @description Where a line is drawn in a trend. */
            levels: components["schemas"]["TripLevel"][];
            /** @description Its name. */
            name: string;
            /**
             * Format: int64
             * @description How often they are taken, in milliseconds: older than a few of these, they are stale.
             */
            poll_ms: number;
            /** @description What it measures, one for each measuring part that travels. */
            readings: components["schemas"]["Reading"][];
            /** @description Its segment. */
            segment: string;
            /** @description What it is to us. */
            standing: components["schemas"]["Standing"];
            /** @description Why it does not measure, in a sentence. */
            trouble: string | null;
        };
        /** @description A value as people and programs give it. */
        Given: string | number | boolean;
        /** @description Something that happened. */
        Happening: {
            /**
             * Format: int64
             * @description When, in milliseconds since 1970.
             */
            at_ms: number;
            /** @description To which gauge. */
            gauge: string | null;
            /**
             * @description What kind of thing: `station`, `bus`, `gauge`, `command`, `note`.
             * @enum {string}
             */
            kind: "station" | "bus" | "gauge" | "command" | "note" | "access" | "alarm";
            /** @description One sentence. */
            text: string;
        };
        /** @description A condition, and whether it holds. */
        Held: {
            /** @description What is the case. */
            found: string;
            /** @description Whether that is enough. */
            holds: boolean;
            /** @description What must be the case. */
            wanted: string;
        };
        /** @description Why, and for how long. */
        Leave: {
            /**
             * Format: int32
             * @description For so many minutes, 1 to 44640; until somebody puts it back if nothing is said.
             */
            minutes?: number | null;
            /** @description Why, in 1 to 500 characters. */
            reason: string;
        };
        /** @description What is asked of whoever logs in. */
        Login: {
            /** @description Their name. */
            name: string;
            /** @description Their password. */
            password: string;
        };
        /** @description Who may act on gauges now. */
        Mastership: {
            /** @description Who wants it. */
            asked_by: string | null;
            /**
             * Format: int64
             * @description Since when.
             */
            asked_ms: number | null;
            /** @description Who; nothing if it is free. */
            holder: string | null;
            /**
             * Format: int64
             * @description Since when, in milliseconds since 1970.
             */
            since_ms: number | null;
        };
        /** @description Everything that is seen at one moment. */
        Moment: {
            alarms: components["schemas"]["ActiveAlarms"];
            gauges: components["schemas"]["Gauge"][];
            mastership: components["schemas"]["Mastership"];
            reading: components["schemas"]["ReadSoFar"][];
            segments: components["schemas"]["Segment"][];
            station: components["schemas"]["Station"];
        };
        /** @description What is asked of whoever wants a new password. */
        NewPassword: {
            /** @description The one they have. */
            current: string;
            /** @description The one they want. */
            new: string;
        };
        /** @description A station on a segment. */
        OnBus: {
            /**
             * Format: int32
             * @description Its address, 0 to 126.
             */
            address: number;
            /** @description What it is, as far as we know. */
            device: string | null;
            /** @description Ident_Number, in hex. */
            ident: string | null;
            /** @description The name we gave it. */
            name: string | null;
            /** @description What it is to us. */
            standing: components["schemas"]["Standing"];
            /** @description What it is doing, in words. */
            words: string;
        };
        /** @description Why an alarm is out of service. */
        OutOfService: {
            /**
             * Format: int64
             * @description When.
             */
            at_ms: number;
            /** @description Why. */
            reason: string;
            /**
             * Format: int64
             * @description When it comes back by itself; nothing if somebody must put it back.
             */
            until_ms: number | null;
            /** @description Who took it out. */
            who: string;
        };
        /** @description Something that was fired and done. */
        Outcome: {
            /** @description What it is now, as it was read back; nothing if it cannot be read. */
            after: string | null;
            /** @description What it was. */
            before: string | null;
            /** @description The gauge. */
            gauge: string;
            /** @description The octets that were sent. */
            octets: string;
            /** @description The order. */
            order: string;
            /** @description The command or the parameter. */
            target: string;
        };
        /** @description A parameter of a gauge. */
        Parameter: {
            /** @description What the manual allows: `R`, `R/W`, ... */
            access: string;
            /** @description The manual's name. */
            name: string;
            /** @description Slot and index, or the number of the parameter channel. */
            numbers: string;
            /** @description Why it could not be read. */
            refusal: string | null;
            /** @description By what it is read and written: `trip-point.1/high-trip-point`. */
            target: string;
            /** @description What it shows now, with its unit; nothing if it could not be read. */
            value: string | null;
            write: components["schemas"]["Writing"] | null;
        };
        /**
         * @description How soon somebody must do something. Ordered: the highest is the greatest.
         * @enum {string}
         */
        Priority: "low" | "medium" | "high";
        /** @description Why there is no answer. */
        Problem: {
            /** @description What was expected and what came. */
            problem: string;
        };
        /** @description How far the parameters of a gauge are read. */
        ReadSoFar: {
            /** @description So many were read. */
            done: number;
            /** @description The gauge. */
            gauge: string;
            /** @description Of so many. */
            of: number;
        };
        /** @description What a measuring part shows. */
        Reading: {
            /**
             * Format: double
             * @description In Pa, corrected for the gas; nothing where no factor holds.
             */
            corrected_pa: number | null;
            /**
             * Format: int32
             * @description The instance or channel, 0 if there is only one.
             */
            instance: number;
            /**
             * Format: double
             * @description In Pa, as indicated; nothing unless there is a value.
             */
            pa: number | null;
            /**
             * @description How the part senses: `pirani`, `hot-cathode`, `cold-cathode`, `diaphragm`, `atmosphere`.
             * @enum {string|null}
             */
            principle: "pirani" | "hot-cathode" | "cold-cathode" | "diaphragm" | "atmosphere" | null;
            /**
             * @description What it is worth: `valid`, `overrange`, `underrange`, `invalid`, `gap`.
             * @enum {string}
             */
            quality: "valid" | "overrange" | "underrange" | "invalid" | "gap";
            /** @description The name under which it is recorded: that of the gauge, with the channel of a controller. */
            series: string;
        };
        /** @description The recorder. */
        RecorderView: {
            /** @description Why it does not, if it does not. */
            error: string | null;
            /**
             * Format: int64
             * @description Samples it could not keep.
             */
            lost: number;
            /**
             * Format: int64
             * @description Events it could not keep.
             */
            lost_events: number;
            /**
             * Format: int64
             * @description When it wrote last, in milliseconds since 1970.
             */
            written_ms: number | null;
        };
        /** @description An alarm that was not acknowledged. */
        RefusedAlarm: {
            /** @description Its name. */
            name: string;
            /** @description Why. */
            problem: string;
        };
        /** @description What a rise of pressure consists of. */
        RiseView: {
            /**
             * Format: double
             * @description How far the part that slows down rises, in Pa; nothing if it cannot be told from the steady one.
             */
            bend_pa: number | null;
            /**
             * Format: double
             * @description How much of the variation is explained, 0 to 1.
             */
            explained: number;
            /**
             * Format: double
             * @description The same as a flow, in Pa m³/s, if the volume is known.
             */
            leak_pa_m3_per_s: number | null;
            /**
             * Format: double
             * @description Its flow at the beginning, in Pa m³/s, if the volume is known.
             */
            outgassing_pa_m3_per_s: number | null;
            /** @description How many samples were fitted. */
            samples: number;
            /**
             * Format: double
             * @description The pressure at the beginning, in Pa.
             */
            start_pa: number;
            /**
             * Format: double
             * @description The part that does not slow down, in Pa/s.
             */
            steady_pa_per_s: number;
            /**
             * Format: double
             * @description Its time constant in seconds.
             */
            tau_s: number | null;
        };
        /** @description What something risks. */
        Risk: {
            /** @description How much. */
            class: components["schemas"]["Class"];
            /** @description In words: those of the table where it has some. */
            words: string;
        };
        /**
         * @description What somebody may do. Who may more may all that those may who may less.
         * @enum {string}
         */
        Role: "viewer" | "operator" | "engineer";
        /** @description What somebody has seen. */
        Seen: {
            /**
             * Format: int64
             * @description Which time the alarm was raised, as it stands in what they have seen.
             */
            occurrence: number;
        };
        /** @description An alarm that somebody has seen. */
        SeenAlarm: {
            /** @description Its name. */
            name: string;
            /**
             * Format: int64
             * @description Which time it was raised.
             */
            occurrence: number;
        };
        /** @description Alarms that somebody has seen. */
        SeenAlarms: {
            /** @description All of them, 1 to 1000. */
            alarms: components["schemas"]["SeenAlarm"][];
        };
        /** @description A segment and everybody on it. */
        Segment: {
            /**
             * Format: int32
             * @description Bits per second.
             */
            baud: number;
            /**
             * Format: double
             * @description How long a cycle takes, in milliseconds.
             */
            cycle_ms: number | null;
            /**
             * Format: int32
             * @description Telegrams that arrived damaged since it runs.
             */
            damaged: number;
            /**
             * Format: int32
             * @description The address of our master.
             */
            master: number;
            /** @description Its name. */
            name: string;
            /** @description Its port. */
            port: string;
            /** @description Where it stands. */
            state: components["schemas"]["SegmentState"];
            /** @description Who is on it. */
            stations: components["schemas"]["OnBus"][];
            /** @description Why it does not run, in a sentence. */
            trouble: string | null;
        };
        /**
         * @description Where a segment stands.
         * @enum {string}
         */
        SegmentState: "waiting" | "listening" | "running";
        /** @description Who asks. */
        Session: {
            /** @description Whether one logs in here. */
            door: components["schemas"]["DoorState"];
            /** @description Their name. */
            name: string;
            /** @description What they may do. */
            role: components["schemas"]["Role"];
            /** @description What has to stand in `x-csrf-token` of everything that is not only looked at; empty before one has logged in. */
            token: string;
        };
        /**
         * @description What a station of a segment is to us.
         * @enum {string}
         */
        Standing: "ourselves" | "master" | "exchanging" | "faulty" | "starting" | "missing" | "foreign";
        /**
         * @description Where an alarm stands.
         * @enum {string}
         */
        State: "normal" | "unacknowledged" | "acknowledged" | "returned" | "out-of-service";
        /** @description The station as a whole. */
        Station: {
            /** @description Its name. */
            name: string;
            /**
             * Format: int64
             * @description What its clock shows, in milliseconds since 1970.
             */
            now_ms: number;
            /** @description Whether the recorder writes. */
            recorder: components["schemas"]["RecorderView"];
            /**
             * Format: int64
             * @description When it began, in milliseconds since 1970.
             */
            started_ms: number;
            /** @description The version of the program. */
            version: string;
        };
        /** @description What came of acknowledging several alarms. */
        Together: {
            /** @description Those that were acknowledged. */
            acknowledged: string[];
            /** @description Those that were not. */
            refused: components["schemas"]["RefusedAlarm"][];
        };
        /** @description A trend: one entry of each list for every pixel in which something was recorded. */
        Trend: {
            /** @description The highest. */
            high: (number | null)[];
            /** @description The lowest pressure in Pa; nothing where there was none. */
            low: (number | null)[];
            /** @description The geometric mean. */
            mean: (number | null)[];
            /** @description What occurred: bit 0 valid, 1 overrange, 2 underrange, 3 invalid, 4 gap. */
            qualities: number[];
            /** @description The name of what was recorded. */
            series: string;
            /** @description Where pixels begin, in milliseconds since 1970, rising. */
            start_ms: number[];
        };
        /** @description A pressure at which something happens. */
        TripLevel: {
            /** @description What happens. */
            name: string;
            /**
             * Format: double
             * @description In Pa.
             */
            pa: number;
        };
        /** @description Why nothing was armed or done. */
        Unmet: {
            /** @description All conditions, if one of them is the reason. */
            conditions: components["schemas"]["Held"][];
            /** @description In a sentence. */
            problem: string;
        };
        /** @description How a webhook is. */
        WebhookView: {
            /** @description Scheme and host; what follows is often a secret. */
            at: string;
            /**
             * Format: int64
             * @description How many it has taken since the station began.
             */
            delivered: number;
            /**
             * Format: int64
             * @description When it took one last, in milliseconds since 1970.
             */
            delivered_ms: number | null;
            /**
             * Format: int64
             * @description Since when, in milliseconds since 1970.
             */
            failing_since_ms: number | null;
            /**
             * Format: int64
             * @description How many were given up since the station began.
             */
            given_up: number;
            /** @description Its name. */
            name: string;
            /** @description Why it does not take the next one, if it does not; it is tried again. */
            problem: string | null;
            /** @description How many letters wait. */
            waiting: number;
        };
        /** @description What is to be armed: a command, or a parameter and its value. */
        Wish: {
            /** @description The command: `degas-on`, `ba.degas-on`. */
            command?: string | null;
            /** @description The parameter: `trip-point.1/high-trip-point`, `2/61`. */
            target?: string | null;
            value?: components["schemas"]["Given"] | null;
        };
        /** @description What it takes to write a parameter. */
        Writing: {
            /** @description Why nobody may from here. */
            barred: string | null;
            /** @description The values it takes, if it takes only these. */
            choices: string[];
            /** @description What it risks. */
            risk: components["schemas"]["Risk"];
            /** @description Who may. */
            role: components["schemas"]["Role"];
            /** @description What it takes, in words with its unit. */
            takes: string;
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
                    "application/json": components["schemas"]["Alarm"][];
                };
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The page that asks is not ours, or whoever asks may not */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
                "application/json": components["schemas"]["SeenAlarms"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Together"];
                };
            };
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Nobody has logged in */
            401: {
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
            /** @description The body takes too long */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is too large */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is no JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
                 * @description The end.
                 * @example 4102444800000
                 */
                to: number;
                /** @description How many at most, 1 to 10000; 200 if nothing is said. */
                most?: number;
                /** @description The name of an alarm; all if nothing is said. */
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
                    "application/json": components["schemas"]["Event"][];
                };
            };
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The page that asks is not ours, or whoever asks may not */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
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
                /** @description The name of the alarm */
                name: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Seen"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Alarm"];
                };
            };
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Nobody has logged in */
            401: {
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
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body takes too long */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It was raised again since, or is acknowledged already */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is too large */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is no JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It is done and could not be written to the disk */
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
    out_of_service: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The name of the alarm */
                name: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Leave"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Alarm"];
                };
            };
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role engineer is needed */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body takes too long */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It is out of service already */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is too large */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is no JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It is done and could not be written to the disk */
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
    return_to_service: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The name of the alarm */
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
                    "application/json": components["schemas"]["Alarm"];
                };
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role engineer is needed */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body takes too long */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It is in service */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is too large */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is no JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It is done and could not be written to the disk */
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
    audit: {
        parameters: {
            query?: {
                /**
                 * @description The beginning, in milliseconds since 1970; everything if nothing is said.
                 * @example 0
                 */
                from?: number;
                /**
                 * @description The end.
                 * @example 4102444800000
                 */
                to?: number;
                /** @description Of this gauge only. */
                gauge?: string;
                /** @description By this person only. */
                who?: string;
                /** @description How many at most, 1 to 100000; 200 if nothing is said, 100000 as CSV. */
                most?: number;
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
                    "application/json": components["schemas"]["Audited"][];
                };
            };
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The page that asks is not ours, or whoever asks may not */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    csv: {
        parameters: {
            query?: {
                /**
                 * @description The beginning, in milliseconds since 1970; everything if nothing is said.
                 * @example 0
                 */
                from?: number;
                /**
                 * @description The end.
                 * @example 4102444800000
                 */
                to?: number;
                /** @description Of this gauge only. */
                gauge?: string;
                /** @description By this person only. */
                who?: string;
                /** @description How many at most, 1 to 100000; 200 if nothing is said, 100000 as CSV. */
                most?: number;
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
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The page that asks is not ours, or whoever asks may not */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
                 * @description The end.
                 * @example 4102444800000
                 */
                to: number;
                /** @description How many at most, 1 to 10000; 200 if nothing is said. */
                most?: number;
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
                    "application/json": components["schemas"]["Happening"][];
                };
            };
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The page that asks is not ours, or whoever asks may not */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    export: {
        parameters: {
            query: {
                /** @description Names, `series` again for each; everything if nothing is said. What is no name may be several, separated by commas. */
                series?: string[];
                /**
                 * @description The beginning, in milliseconds since 1970.
                 * @example 0
                 */
                from: number;
                /**
                 * @description The end.
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
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The page that asks is not ours, or whoever asks may not */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
                    "application/json": components["schemas"]["Gauge"][];
                };
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The page that asks is not ours, or whoever asks may not */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    gauge: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The name of the gauge */
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
                    "application/json": components["schemas"]["Gauge"];
                };
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The page that asks is not ours, or whoever asks may not */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    arm: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The name of the gauge */
                name: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Wish"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Armed"];
                };
            };
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body did not come */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not the mastership, a condition that does not hold, or a gauge that does not answer */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Unmet"];
                };
            };
            /** @description The body is too long */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is no JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    blocks: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The name of the gauge */
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
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The page that asks is not ours, or whoever asks may not */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
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
    commands: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The name of the gauge */
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
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The page that asks is not ours, or whoever asks may not */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
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
                    "text/event-stream": components["schemas"]["Moment"];
                };
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The page that asks is not ours, or whoever asks may not */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The page that asks is not ours, or whoever asks may not */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The station has no users */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body takes too long */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is too large */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is no JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The page that asks is not ours, or whoever asks may not */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body takes too long */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is too large */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is no JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    mastership: {
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
                    "application/json": components["schemas"]["Mastership"];
                };
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The page that asks is not ours, or whoever asks may not */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    ask: {
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
                    "application/json": components["schemas"]["Mastership"];
                };
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body takes too long */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Unmet"];
                };
            };
            /** @description The body is too large */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is no JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
                    "application/json": components["schemas"]["Mastership"];
                };
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body takes too long */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Unmet"];
                };
            };
            /** @description The body is too large */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is no JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
                    "application/json": components["schemas"]["Mastership"];
                };
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body takes too long */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Unmet"];
                };
            };
            /** @description The body is too large */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is no JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
                    "application/json": components["schemas"]["Mastership"];
                };
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body takes too long */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Unmet"];
                };
            };
            /** @description The body is too large */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is no JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    disarm: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The order */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body takes too long */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Unmet"];
                };
            };
            /** @description The body is too large */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is no JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    fire: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The order */
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
                    "application/json": components["schemas"]["Outcome"];
                };
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body takes too long */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not in time, not the mastership, not the same as it was, or the gauge refused */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Unmet"];
                };
            };
            /** @description The body is too large */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is no JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The audit trail cannot be written */
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
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The station has no users */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body takes too long */
            408: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is too large */
            413: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The body is no JSON */
            415: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    rise: {
        parameters: {
            query: {
                /** @description The name of what was recorded. */
                series: string;
                /**
                 * @description The beginning, in milliseconds since 1970.
                 * @example 0
                 */
                from: number;
                /**
                 * @description The end.
                 * @example 4102444800000
                 */
                to: number;
                /** @description The volume in m³, for flows. */
                volume_m3?: number;
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
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The page that asks is not ours, or whoever asks may not */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The page that asks is not ours, or whoever asks may not */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The page that asks is not ours, or whoever asks may not */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The page that asks is not ours, or whoever asks may not */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    trend: {
        parameters: {
            query: {
                /** @description The name of what was recorded. */
                series: string;
                /**
                 * @description The beginning, in milliseconds since 1970.
                 * @example 0
                 */
                from: number;
                /**
                 * @description The end.
                 * @example 4102444800000
                 */
                to: number;
                /** @description How many pixels there are, 1 to 20000; 1000 if nothing is said. */
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
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The page that asks is not ours, or whoever asks may not */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Nobody has logged in */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The page that asks is not ours, or whoever asks may not */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description This computer is called otherwise */
            421: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Too often; the header Retry-After says for how long */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
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
