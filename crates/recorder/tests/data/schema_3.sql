-- A database of schema version 3, as the program wrote it before the columns were renamed (commit cf78c46): every table, every
-- quality, every kind of event and every audit action. Printed by `sqlite3 FILE .dump`; the last line sets the version.
PRAGMA foreign_keys=OFF;
BEGIN TRANSACTION;
CREATE TABLE gauge (
        id   INTEGER PRIMARY KEY,
        name TEXT NOT NULL UNIQUE
    );
INSERT INTO gauge VALUES(1,'chamber');
INSERT INTO gauge VALUES(2,'tpg.2');
INSERT INTO gauge VALUES(3,'tpg');
CREATE TABLE sample (
        gauge   INTEGER NOT NULL REFERENCES gauge,
        at      INTEGER NOT NULL,
        pa      REAL,
        quality INTEGER NOT NULL,
        PRIMARY KEY (gauge, at)
    ) WITHOUT ROWID;
INSERT INTO sample VALUES(1,1767225600000000,0.00010000000000000000479,0);
INSERT INTO sample VALUES(1,1767225601000000,0.00020000000000000000958,0);
INSERT INTO sample VALUES(1,1767225602000000,0.00030000000000000002792,0);
INSERT INTO sample VALUES(1,1767225603000000,0.00040000000000000001916,0);
INSERT INTO sample VALUES(1,1767225604000000,0.0005000000000000000104,0);
INSERT INTO sample VALUES(1,1767225605000000,0.00060000000000000005585,0);
INSERT INTO sample VALUES(1,1767225606000000,0.00069999999999999999288,0);
INSERT INTO sample VALUES(1,1767225607000000,0.00080000000000000003833,0);
INSERT INTO sample VALUES(1,1767225608000000,0.00090000000000000008378,0);
INSERT INTO sample VALUES(1,1767225609000000,0.0010000000000000000208,0);
INSERT INTO sample VALUES(1,1767225610000000,0.0011000000000000000662,0);
INSERT INTO sample VALUES(1,1767225611000000,0.0012000000000000001117,0);
INSERT INTO sample VALUES(1,1767225612000000,100000.0,1);
INSERT INTO sample VALUES(1,1767225613000000,1.0000000000000000209e-08,2);
INSERT INTO sample VALUES(1,1767225614000000,NULL,3);
INSERT INTO sample VALUES(1,1767225615000000,NULL,4);
INSERT INTO sample VALUES(2,1767225600000000,0.5,0);
INSERT INTO sample VALUES(2,1767225601000000,0.5,0);
INSERT INTO sample VALUES(2,1767225602000000,0.5,0);
INSERT INTO sample VALUES(2,1767225603000000,0.5,0);
CREATE TABLE rollup (
        level     INTEGER NOT NULL,
        gauge     INTEGER NOT NULL REFERENCES gauge,
        start     INTEGER NOT NULL,
        low       REAL,
        high      REAL,
        decades   REAL NOT NULL,
        count     INTEGER NOT NULL,
        qualities INTEGER NOT NULL,
        PRIMARY KEY (level, gauge, start)
    ) WITHOUT ROWID;
INSERT INTO rollup VALUES(1,1,1767225600000000,0.00010000000000000000479,0.0010000000000000000208,-33.440236967123205147,10,1);
INSERT INTO rollup VALUES(1,1,1767225610000000,1.0000000000000000209e-08,100000.0,-8.8794260687941495291,4,31);
INSERT INTO rollup VALUES(1,2,1767225600000000,0.5,0.5,-1.204119982655924792,4,1);
INSERT INTO rollup VALUES(2,1,1767225600000000,1.0000000000000000209e-08,100000.0,-42.31966303591735823,14,31);
INSERT INTO rollup VALUES(2,2,1767225600000000,0.5,0.5,-1.204119982655924792,4,1);
INSERT INTO rollup VALUES(3,1,1767225600000000,1.0000000000000000209e-08,100000.0,-42.31966303591735823,14,31);
INSERT INTO rollup VALUES(3,2,1767225600000000,0.5,0.5,-1.204119982655924792,4,1);
INSERT INTO rollup VALUES(4,1,1767225600000000,1.0000000000000000209e-08,100000.0,-42.31966303591735823,14,31);
INSERT INTO rollup VALUES(4,2,1767225600000000,0.5,0.5,-1.204119982655924792,4,1);
CREATE TABLE event (
        id    INTEGER PRIMARY KEY,
        at    INTEGER NOT NULL,
        gauge INTEGER REFERENCES gauge,
        kind  TEXT NOT NULL,
        text  TEXT NOT NULL
    );
INSERT INTO event VALUES(1,1767225600000000,NULL,'station','the station begins');
INSERT INTO event VALUES(2,1767225601000000,1,'bus','chamber: it exchanges data');
INSERT INTO event VALUES(3,1767225602000000,3,'gauge','tpg: sensor 2 fails');
INSERT INTO event VALUES(4,1767225603000000,1,'command','chamber: ba.degas-on by Otto: done');
INSERT INTO event VALUES(5,1767225604000000,NULL,'note','bake-out begins');
INSERT INTO event VALUES(6,1767225605000000,NULL,'access','Otto (operator) logged in from 127.0.0.1');
INSERT INTO event VALUES(7,1767225606000000,1,'alarm','alarm "chamber: no data" (medium) raised');
CREATE TABLE audit (
        id      INTEGER PRIMARY KEY AUTOINCREMENT,
        at      INTEGER NOT NULL,
        what    TEXT NOT NULL,
        of      INTEGER REFERENCES audit,
        who     TEXT NOT NULL,
        role    TEXT NOT NULL,
        peer    TEXT,
        gauge   TEXT,
        segment TEXT,
        address INTEGER,
        target  TEXT,
        before  TEXT,
        after   TEXT,
        outcome TEXT,
        order_id TEXT
    );
INSERT INTO audit VALUES(1,1767225601000000,'mastership',NULL,'Otto','operator','127.0.0.1',NULL,NULL,NULL,NULL,NULL,NULL,'has taken the mastership, which was free',NULL);
INSERT INTO audit VALUES(2,1767225602000000,'fired',NULL,'Otto','operator','127.0.0.1','chamber','hall',5,'Hot Cathode Block State Command (1:2/14)','off','degas-on',NULL,'646f-1');
INSERT INTO audit VALUES(3,1767225603000000,'outcome',2,'Otto','operator','127.0.0.1','chamber','hall',5,'Hot Cathode Block State Command (1:2/14)','off','degas-on','done','646f-1');
INSERT INTO audit VALUES(4,1767225604000000,'refused',NULL,'Erna','operator','127.0.0.1','chamber','hall',5,'Hot Cathode Block State Command (1:2/14)','off','degas-on',NULL,'646f-1');
INSERT INTO audit VALUES(5,1767225605000000,'disarmed',NULL,'Erna','operator','127.0.0.1','chamber','hall',5,'Hot Cathode Block State Command (1:2/14)','off','degas-on',NULL,'646f-1');
INSERT INTO audit VALUES(6,1767225606000000,'acknowledged',NULL,'Erna','operator','127.0.0.1','chamber','hall',5,'Hot Cathode Block State Command (1:2/14)','off','degas-on',NULL,'646f-1');
INSERT INTO audit VALUES(7,1767225607000000,'taken-out-of-service',NULL,'Erna','operator','127.0.0.1','chamber','hall',5,'Hot Cathode Block State Command (1:2/14)','off','degas-on',NULL,'646f-1');
INSERT INTO audit VALUES(8,1767225608000000,'returned-to-service',NULL,'Erna','operator','127.0.0.1','chamber','hall',5,'Hot Cathode Block State Command (1:2/14)','off','degas-on',NULL,'646f-1');
CREATE TABLE alarm (
        name            TEXT PRIMARY KEY,
        state           TEXT NOT NULL,
        since           INTEGER NOT NULL,
        occurrence      INTEGER NOT NULL,
        raised          INTEGER,
        value           REAL,
        text            TEXT NOT NULL,
        acknowledged_by TEXT,
        acknowledged_at INTEGER,
        out_by          TEXT,
        out_at          INTEGER,
        out_reason      TEXT,
        out_until       INTEGER
    ) WITHOUT ROWID;
INSERT INTO alarm VALUES('chamber too high','acknowledged',1767225609000000,1767225608000,1767225608000000,2.5,'chamber shows 2.50e-2 mbar, above the limit of 1.00e-2 mbar','Otto',1767225609000000,NULL,NULL,NULL,NULL);
INSERT INTO alarm VALUES('tpg: no data','out-of-service',1767225610000000,0,NULL,NULL,'',NULL,NULL,'Erna',1767225610000000,'calibration',1767229200000000);
CREATE TABLE alarm_history (
        id         INTEGER PRIMARY KEY,
        at         INTEGER NOT NULL,
        alarm      TEXT NOT NULL,
        what       TEXT NOT NULL,
        state      TEXT NOT NULL,
        priority   TEXT NOT NULL,
        subject    TEXT,
        occurrence INTEGER NOT NULL,
        who        TEXT,
        value      REAL,
        unit       TEXT,
        text       TEXT NOT NULL
    );
INSERT INTO alarm_history VALUES(1,1767225608000000,'chamber too high','raised','unacknowledged','high','chamber',1767225608000,NULL,2.5,'Pa','');
INSERT INTO alarm_history VALUES(2,1767225609000000,'chamber too high','acknowledged','acknowledged','high','chamber',1767225608000,'Otto',2.5,'Pa','');
CREATE TABLE letter (
        id   INTEGER PRIMARY KEY AUTOINCREMENT,
        hook TEXT NOT NULL,
        at   INTEGER NOT NULL,
        body TEXT NOT NULL
    );
INSERT INTO letter VALUES(2,'log',1767225609000000,'{"alarm":"chamber too high","what":"acknowledged"}');
INSERT INTO sqlite_sequence VALUES('audit',8);
INSERT INTO sqlite_sequence VALUES('letter',2);
CREATE INDEX event_at ON event (at);
CREATE INDEX audit_at ON audit (at);
CREATE UNIQUE INDEX audit_of ON audit (of) WHERE of IS NOT NULL;
CREATE TRIGGER audit_is_not_changed BEFORE UPDATE ON audit
        BEGIN SELECT RAISE(ABORT, 'the audit trail is not changed'); END;
CREATE TRIGGER audit_is_not_deleted BEFORE DELETE ON audit
        BEGIN SELECT RAISE(ABORT, 'the audit trail is not deleted'); END;
CREATE INDEX alarm_history_at ON alarm_history (at);
CREATE INDEX letter_hook ON letter (hook, id);
COMMIT;
PRAGMA user_version = 3;
