// Who sits here, and what they may do.

import { useEffect, useState } from 'preact/hooks'
import { get, type Role, type Session } from './api.ts'

const ROLES: Role[] = ['viewer', 'operator', 'engineer']

/** Nobody is known to be more than a viewer before the station says so. */
const NOBODY: Session = { name: '', role: 'viewer' }

let session = NOBODY
const listeners = new Set<() => void>()

/** Asks the station again who sits here. */
export async function whoami(): Promise<void> {
  session = await get<Session>('/api/session', {}).catch(() => NOBODY)
  listeners.forEach((listener) => listener())
}

export function useSession(): Session {
  const [shown, setShown] = useState(session)
  useEffect(() => {
    const changed = (): void => setShown(session)
    listeners.add(changed)
    changed()
    return () => void listeners.delete(changed)
  }, [])
  return shown
}

/** Whether somebody with this role may do what `needed` is needed for. */
export const may = ({ role }: Session, needed: Role): boolean => ROLES.indexOf(role) >= ROLES.indexOf(needed)
