// The state of a gateway in words.

import type { Gateway } from '../api/types.ts'
import { t } from '../texts/texts.ts'

/** The gateways by the names of their tables in the station's file. */
const TITLES: Record<string, string> = {
  epics: 'EPICS',
  opcua: 'OPC UA',
  mqtt: 'MQTT',
  sparkplug: 'Sparkplug B',
  modbus: 'Modbus TCP',
  prometheus: 'Prometheus',
}

export const gatewayTitle = (name: string): string => TITLES[name] ?? name

/** Whether it runs; why not, if the gateway has said so. */
export function gatewayState({ is_running, problem }: Pick<Gateway, 'is_running' | 'problem'>): string {
  if (is_running) return t.gateways.running
  return problem ? t.gateways.failed(problem) : t.gateways.starting
}
