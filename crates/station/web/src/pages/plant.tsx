// The plant as a picture, and the same as a list.

import type { JSX } from 'preact'
import type { Alarm, PlantPicture } from '../api/types.ts'
import { AlarmCounts, PriorityMark } from '../components/alarm-marks.tsx'
import { hasPicture, Picture, Story, usePlant, useVolumes } from '../components/plant-picture.tsx'
import { boundOf, ReadingText } from '../components/pressure.tsx'
import { QueryState } from '../components/query-state.tsx'
import { activeCounts } from '../lib/alarms.ts'
import { type PlacedReading, stateWords, type VolumeState } from '../lib/picture.ts'
import { usePartStates, useSnapshot } from '../live.ts'
import { gaugePath, Link } from '../router.tsx'
import { useUnit } from '../settings.ts'
import { t } from '../texts/texts.ts'

export function PlantPage(): JSX.Element {
  const { plant, query } = usePlant()
  const { plant: now } = useSnapshot()
  return (
    <>
      <h1 class="visually-hidden">{t.pages['/plant']}</h1>
      <QueryState of={[query]} />
      <Story now={now} />
      {plant && hasPicture(plant) && (
        <div class="beside-picture">
          <div class="panel">
            <Picture plant={plant} />
          </div>
          <Lists plant={plant} />
        </div>
      )}
      {plant && !hasPicture(plant) && <p class="waiting">{t.plant.none}</p>}
    </>
  )
}

/** A reading and its active alarms. Those of a whole gauge stand at its only reading, or in a line of their own before its readings. */
function ReadingLine({ placed, state }: { placed: PlacedReading; state: VolumeState }): JSX.Element {
  const unit = useUnit()
  const { gauge, reading } = placed
  const ofGauge = state.alarms.filter((alarm) => alarm.gauge === gauge.name)
  const ofAll = ofGauge.filter(({ series }) => !series)
  const ofReading = ofGauge.filter(({ series }) => series === reading.series)
  const isOnly = gauge.readings.length === 1
  const isFirst = state.readings.find((other) => other.gauge.name === gauge.name) === placed
  return (
    <>
      {!isOnly && isFirst && ofAll.length > 0 && (
        <li>
          <Link to={gaugePath(gauge.name)}>{gauge.name}</Link> <NamedAlarms alarms={ofAll} />
        </li>
      )}
      <li>
        <Link to={gaugePath(gauge.name)}>{reading.series}</Link>{' '}
        <ReadingText pa={boundOf(reading)} quality={placed.quality} unit={unit} />
        <NamedAlarms alarms={isOnly ? ofGauge : ofReading} />
      </li>
    </>
  )
}

function NamedAlarms({ alarms }: { alarms: Alarm[] }): JSX.Element {
  return (
    <>
      {alarms.map(({ name, priority }) => (
        <span class="reading-alarm" key={name}>
          <PriorityMark priority={priority} active={true} /> {name}
        </span>
      ))}
    </>
  )
}

/** From this width on the list is open: the picture leaves the lower half of such a window empty. */
const WIDE = '(min-width: 64rem)'

/** All gauges of the volumes, and all valves and pumps: what the picture shows, for a screen reader and for details. */
function Lists({ plant }: { plant: PlantPicture }): JSX.Element {
  const volumes = useVolumes(plant)
  const states = usePartStates()
  const hasZones = plant.volumes.some(({ zone }) => zone !== null)
  return (
    <details class="panel plant-lists" open={matchMedia(WIDE).matches}>
      <summary>{t.plant.asList}</summary>
      <div class="plant-tables">
        <table class="stacked" aria-label={t.plant.volumes}>
          <thead>
            <tr>
              <th>{t.plant.volume}</th>
              {hasZones && <th>{t.plant.zone}</th>}
              <th>{t.plant.alarms}</th>
              <th>{t.plant.gauges}</th>
            </tr>
          </thead>
          <tbody>
            {volumes.map(({ volume, state }) => {
              const counts = activeCounts(state.alarms)
              return (
                <tr key={volume.name} data-list-volume={volume.name}>
                  <th scope="row">{volume.name}</th>
                  {hasZones && <td data-title={t.plant.zone}>{volume.zone}</td>}
                  <td data-title={t.plant.alarms}>
                    {counts.length > 0 ? <AlarmCounts counts={counts} /> : t.common.none}
                  </td>
                  <td>
                    <ul>
                      {state.readings.map((placed) => (
                        <ReadingLine placed={placed} state={state} key={placed.reading.series} />
                      ))}
                      {state.silent.map((name) => (
                        <li key={name}>
                          {name} <span class="no-pressure stale">{t.common.noData}</span>
                          <NamedAlarms alarms={state.alarms.filter(({ gauge }) => gauge === name)} />
                        </li>
                      ))}
                    </ul>
                  </td>
                </tr>
              )
            })}
          </tbody>
        </table>
        <table class="stacked" aria-label={t.plant.parts}>
          <thead>
            <tr>
              <th>{t.plant.part}</th>
              <th>{t.plant.kind}</th>
              <th>{t.common.state}</th>
              <th>{t.plant.volumes}</th>
            </tr>
          </thead>
          <tbody>
            {plant.parts.map((part) => (
              <tr key={part.name} data-list-part={part.name}>
                <th scope="row">{part.name}</th>
                <td>{t.plant.kinds[part.kind]}</td>
                <td data-title={t.common.state}>{stateWords(part, states[part.name] ?? undefined)}</td>
                <td data-title={t.plant.volumes}>{part.volumes.join(', ')}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </details>
  )
}
