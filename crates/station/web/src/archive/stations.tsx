// All stations: problems first, then each station with its latest readings.

import '../pages/overview.css'
import type { JSX } from 'preact'
import { useState } from 'preact/hooks'
import { AlarmStateMark, PriorityMark } from '../components/alarm-marks.tsx'
import { Choice, SearchField } from '../components/fields.tsx'
import { ReadingText } from '../components/pressure.tsx'
import { isActive } from '../lib/alarms.ts'
import { age } from '../lib/format.ts'
import { matchesWords } from '../lib/search.ts'
import type { Unit } from '../lib/units.ts'
import { Link } from '../router.tsx'
import { useUnit } from '../settings.ts'
import { t } from '../texts/texts.ts'
import { useArchive, useLive } from './live.ts'
import { isOpen, isSilent, type Station, stationsOf } from './plant.ts'
import { trendPath } from './trends.tsx'
import type { ActiveAlarm, LatestReading } from './types.ts'

/** The readings of few stations are open from the start. */
const MOST_OPEN = 4

/** The most alarms of a station in the list of problems. */
const MOST_ALARMS = 5

export function Stations(): JSX.Element {
  const { now } = useLive()
  const [text, setText] = useState('')
  const [plant, setPlant] = useState('')
  const all = stationsOf(useArchive())
  const plants = [...new Set(all.map((station) => station.plant))].sort()
  const isFiltered = text !== ''
  const shown = all
    .filter((station) => !plant || station.plant === plant)
    .map((station) => {
      const readings = station.readings.filter((reading) => matches(station, reading, text))
      return { ...station, all: station.readings.length, readings }
    })
    .filter((station) => !isFiltered || station.readings.length > 0 || matchesWords([station.name], text))
  const problems = shown.filter((station) => isSilent(station, now) || station.alarms.some(isOpen))
  return (
    <>
      <div class="bar">
        <h1 class="visually-hidden">{t.archive.stations}</h1>
        <SearchField label={t.archive.search} value={text} onInput={setText} />
        {plants.length > 1 && (
          <Choice
            label={t.pages['/plant']}
            value={plant}
            options={[['', t.archive.allPlants], ...plants.map((name): [string, string] => [name, name])]}
            onChange={setPlant}
          />
        )}
        <span class="muted" role="status">
          {t.archive.counted(shown.length, all.length)}
        </span>
      </div>
      {problems.length > 0 && (
        <section class="segment problems" aria-label={t.archive.problems}>
          <h2>{t.archive.problems}</h2>
          <ul class="rows">
            {problems.map((station) => (
              <Problem station={station} now={now} key={station.name} />
            ))}
          </ul>
        </section>
      )}
      {shown.map((station) => (
        <StationRows station={station} now={now} isOpen={isFiltered || all.length <= MOST_OPEN} key={station.name} />
      ))}
      {all.length === 0 && <p class="waiting">{t.archive.nothingYet}</p>}
      {all.length > 0 && shown.length === 0 && <p class="muted">{t.archive.noMatch}</p>}
    </>
  )
}

const matches = ({ name, plant }: Station, { series }: LatestReading, text: string): boolean =>
  matchesWords([name, plant, series], text)

function Problem({ station, now }: { station: Station; now: number }): JSX.Element {
  const open = station.alarms.filter(isOpen)
  return (
    <li class="row station-problem" data-station={station.name}>
      <strong>{station.name}</strong>
      {isSilent(station, now) && <span>{silence(station, now)}</span>}
      {open.slice(0, MOST_ALARMS).map((alarm) => (
        <AlarmLine alarm={alarm} key={alarm.alarm} />
      ))}
      {open.length > MOST_ALARMS && <Link to="/alarms">{t.archive.moreAlarms(open.length - MOST_ALARMS)}</Link>}
    </li>
  )
}

const silence = ({ stored_ms }: Station, now: number): string =>
  stored_ms ? t.archive.silentFor(age(now - stored_ms)) : t.archive.silent

export function AlarmLine({ alarm }: { alarm: ActiveAlarm }): JSX.Element {
  return (
    <span class="alarm-line">
      <PriorityMark priority={alarm.priority} active={isActive(alarm)} /> <AlarmStateMark state={alarm.state} />{' '}
      {alarm.text || alarm.alarm}
    </span>
  )
}

interface StationProps {
  /** The station with the readings that match, of `all`. */
  station: Station & { all: number }
  now: number
  isOpen: boolean
}

function StationRows({ station, now, isOpen }: StationProps): JSX.Element {
  const [opened, setOpened] = useState(false)
  const unit = useUnit()
  const open = isOpen || opened
  const { name, plant, all, readings, stored_ms, missing, put_aside, put_aside_reason } = station
  return (
    <section class="segment" aria-label={t.archive.stationOf(name)} data-station={name}>
      <details open={open} onToggle={(event) => !isOpen && setOpened(event.currentTarget.open)}>
        <summary>
          <h2>{name}</h2>{' '}
          <span class="muted">
            {plant}, {t.archive.series(readings.length, all)},{' '}
            {stored_ms ? t.archive.lastBatch(age(Math.max(0, now - stored_ms))) : t.archive.noBatch}
            {missing > 0 && `, ${t.archive.missing(missing)}`}
          </span>
          {put_aside > 0 && (
            <span class="put-aside">
              {' '}
              {t.archive.putAside(put_aside)}: {put_aside_reason}
            </span>
          )}
        </summary>
        {open && (
          <ul class="rows">
            {readings.map((reading) => (
              <Reading reading={reading} silent={isSilent(station, now)} unit={unit} now={now} key={reading.series} />
            ))}
          </ul>
        )}
      </details>
    </section>
  )
}

interface ReadingProps {
  reading: LatestReading
  /** The station is silent: its readings are old. */
  silent: boolean
  unit: Unit
  now: number
}

function Reading({ reading, silent, unit, now }: ReadingProps): JSX.Element {
  const { station, series, pa, limit_pa, quality, at_ms, mean_of_ms } = reading
  const end = at_ms + (mean_of_ms ?? 0)
  return (
    <li class={silent ? 'row stale' : 'row'} data-series={`${station}/${series}`}>
      <Link to={trendPath([`${station}/${series}`])}>{series}</Link>
      <span class="row-readings">
        <span>
          <ReadingText pa={pa ?? limit_pa ?? null} quality={quality} unit={unit} />
        </span>
      </span>
      <span class="muted reading-age">
        {mean_of_ms && `${t.archive.meanOf(age(mean_of_ms))}, `}
        {t.common.ago(age(Math.max(0, now - end)))}
      </span>
    </li>
  )
}
