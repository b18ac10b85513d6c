// The numbers of a plant with their intervals, what is not determined in words, the pressure to come, and what would help.

import type { ComponentChildren, JSX } from 'preact'
import type { Bounds, Plant } from '../../api/types.ts'
import { Pressure } from '../../components/pressure.tsx'
import { Sprays } from '../../components/sprays.tsx'
import { age, number } from '../../lib/format.ts'
import { boundsText, timesText, worth } from '../../lib/plant.ts'
import { useUnit } from '../../settings.ts'

interface Props {
  plant: Plant
  /** The target as typed. */
  target: string
}

export function Result({ plant, target }: Props): JSX.Element {
  const { title, sentence } = worth(plant)
  return (
    <section class="panel result" aria-label="Result">
      <h2>{title}</h2>
      <p>{sentence}</p>
      <Numbers plant={plant} />
      <p class="muted">
        {plant.samples} samples.{' '}
        {plant.rise
          ? `The valve was closed from ${age(plant.rise.closed_s * 1000)} to ${age(plant.rise.opened_s * 1000)} after the start.`
          : 'No rise with a closed valve: leak and speed follow from the curve alone.'}{' '}
        95 % intervals,{' '}
        {plant.accuracy === null
          ? 'without the uncertainty of the gauge'
          : `with an accuracy of the gauge of ±${number((plant.accuracy ?? 0) * 100)} %`}
        .
      </p>
      <Sprays sprays={plant.sprays} />
      <Outlook plant={plant} target={target} />
      <h3>What would help most</h3>
      <p class="muted">The pressure after another day of pumping, divided by that with one change.</p>
      <ol class="remedies">
        {plant.remedies.map(({ remedy, text, divided_by }) => (
          <li key={remedy}>
            {text}: <strong>{boundsText(divided_by, 1).value}</strong> ({boundsText(divided_by, 1).interval})
          </li>
        ))}
      </ol>
    </section>
  )
}

interface Row {
  name: ComponentChildren
  value: Bounds
  /** The unit, and its size in that of the API. */
  unit: string
  size: number
  note: string | null
}

function Numbers({ plant }: { plant: Plant }): JSX.Element {
  const unit = useUnit()
  const flow = (name: string, { flow, note }: Plant['leak']): Row => ({
    name,
    value: flow.mbar_l_per_s,
    unit: 'mbar L/s',
    size: 1,
    note: note ?? null,
  })
  const number = (name: ComponentChildren, { value, note }: Plant['exponent'], unit: string, size: number): Row => ({
    name,
    value,
    unit,
    size,
    note: note ?? null,
  })
  const volume = number('volume', plant.volume_m3, 'L', 1e-3)
  const rows: Row[] = [
    plant.is_volume_given ? { ...volume, note: 'as given' } : volume,
    ...plant.speeds.map(({ pa, m3_per_s }) =>
      number(
        <>
          speed at <Pressure pa={pa} unit={unit} />
        </>,
        m3_per_s,
        'L/s',
        1e-3,
      ),
    ),
    flow('leak', plant.leak),
    flow('outgassing after 1 h', plant.outgassing_1h),
    number('exponent of outgassing', plant.exponent, '', 1),
  ]
  const { value, note } = plant.ultimate_pa
  return (
    <table>
      <caption class="visually-hidden">Numbers of the plant</caption>
      <thead>
        <tr>
          <th scope="col">Quantity</th>
          <th scope="col">Value</th>
          <th scope="col">95 % interval</th>
        </tr>
      </thead>
      <tbody>
        {rows.map(({ name, value, unit, size, note }, place) => (
          <tr key={place}>
            <th scope="row">
              {name}
              {note && <small>{note}</small>}
            </th>
            <td>
              {boundsText(value, size).value} {unit}
            </td>
            <td>{boundsText(value, size).interval}</td>
          </tr>
        ))}
        <tr>
          <th scope="row">
            ultimate pressure of the pump
            {note && <small>{note}</small>}
          </th>
          <td>
            <Pressure pa={value.mean} unit={unit} />
          </td>
          <td>
            <PressureInterval bounds={value} />
          </td>
        </tr>
      </tbody>
    </table>
  )
}

function PressureInterval({ bounds: { low, high } }: { bounds: Bounds }): JSX.Element {
  const unit = useUnit()
  return (
    <>
      <Pressure pa={low} unit={unit} /> to{' '}
      {high === null || high === undefined ? 'no limit' : <Pressure pa={high} unit={unit} />}
    </>
  )
}

function Outlook({ plant, target }: Props): JSX.Element {
  const unit = useUnit()
  const { by_leak, by_outgassing, by_pump } = plant.at_end_pa
  const facts: [string, Bounds][] = [
    ['pressure at the end of the record by the leak', by_leak],
    ['by outgassing', by_outgassing],
    ['by the pump', by_pump],
    ['after another day of pumping', plant.after_another_day_pa],
  ]
  return (
    <dl class="facts">
      {facts.map(([name, bounds]) => (
        <div key={name}>
          <dt>{name}</dt>
          <dd>
            <Pressure pa={bounds.mean} unit={unit} /> (<PressureInterval bounds={bounds} />)
          </dd>
        </div>
      ))}
      {target !== '' && (
        <div>
          <dt>
            {target} {unit} is reached after
          </dt>
          <dd>{plant.target_s ? timesText(plant.target_s) : 'not within a year'}</dd>
        </div>
      )}
    </dl>
  )
}
