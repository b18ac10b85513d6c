// The user who is logged in, and their role.

import {
  beginOpenId,
  completeOpenId,
  fetchSession,
  login as requestLogin,
  logout as requestLogout,
  changePassword as requestNewPassword,
} from './api/calls.ts'
import { csrf, RequestError } from './api/request.ts'
import type { Role, Session } from './api/types.ts'
import { go } from './router.tsx'
import { createStore, useStore } from './store.ts'

const ROLES: Role[] = ['viewer', 'operator', 'engineer']

const LOGGED_OUT: Session = {
  name: '',
  role: 'viewer',
  token: '',
  login: 'logged-out',
  has_password: false,
  provider: null,
}

/** The page to which an OpenID provider sends the browser back. */
const RETURN_PAGE = '/openid'

/** In the storage of the window: the page that a login at the provider returns to. */
const RETURN_KEY = 'profivac-openid'

const RETRY_MS = 1_000

export interface SessionState {
  /** `null` before the first answer of the station. */
  session: Session | null
  /** The user whose session has ended without a logout. */
  expiredUser: string | null
  /** Why the login at an OpenID provider has failed, as the station says it. */
  loginError: string | null
}

const store = createStore<SessionState>({ session: null, expiredUser: null, loginError: null })

function update(session: Session, expiredUser: string | null = null): void {
  csrf.token = session.token
  const loginError = session.login === 'logged-out' ? store.get().loginError : null
  store.set({ session, expiredUser, loginError })
}

/** Takes over what the station says about the session. */
function receive(session: Session): void {
  const { session: before, expiredUser } = store.get()
  const hasEnded = before !== null && before.login !== 'logged-out'
  if (session.login === 'logged-out') update(session, hasEnded ? before.name : expiredUser)
  else update(session)
}

/** Asks the station for the session; again and again until its first answer. */
export async function refreshSession(): Promise<void> {
  try {
    receive(await fetchSession())
  } catch {
    if (!store.get().session) setTimeout(() => void refreshSession(), RETRY_MS)
  }
}

export async function login(name: string, password: string): Promise<void> {
  receive(await requestLogin(name, password))
}

/** Goes to the OpenID provider; the browser returns to the present page. */
export async function loginAtProvider(): Promise<void> {
  const { url } = await beginOpenId()
  try {
    sessionStorage.setItem(RETURN_KEY, location.pathname + location.search)
  } catch {
    // The browser refuses: the login returns to the first page.
  }
  location.assign(url)
}

/** Where a login at the provider returns to: a page of this dashboard. */
function takeReturnPage(): string {
  try {
    const page = sessionStorage.getItem(RETURN_KEY)
    sessionStorage.removeItem(RETURN_KEY)
    return page?.startsWith('/') && !page.startsWith('//') ? page : '/'
  } catch {
    return '/'
  }
}

/** Begins: completes a login at the provider if the browser comes from there, and asks the station for the session. */
export async function startSession(): Promise<void> {
  if (location.pathname === RETURN_PAGE) await returnFromProvider()
  await refreshSession()
}

async function returnFromProvider(): Promise<void> {
  const given = new URLSearchParams(location.search)
  // State and code disappear from the address before anything else happens.
  go(takeReturnPage(), true)
  const state = given.get('state')
  if (state === null) return
  try {
    receive(await completeOpenId(state, given.get('code'), given.get('error'), given.get('iss')))
  } catch (error) {
    store.set({ ...store.get(), loginError: error instanceof Error ? error.message : String(error) })
  }
}

export async function changePassword(current: string, next: string): Promise<void> {
  receive(await requestNewPassword(current, next))
}

export async function logout(): Promise<void> {
  const atProvider = await requestLogout().catch((error: unknown) => {
    // 401: the session had ended before.
    if (error instanceof RequestError && error.status === 401) return undefined
    throw error
  })
  update(loggedOut())
  // The provider asks whether its own session ends too.
  if (atProvider) location.assign(atProvider.url)
}

/** No user, at the same station. */
const loggedOut = (): Session => ({ ...LOGGED_OUT, provider: store.get().session?.provider ?? null })

csrf.onSessionEnd = () => {
  const { session } = store.get()
  if (session && session.login !== 'logged-out') update(loggedOut(), session.name)
}

csrf.refresh = async () => {
  const before = store.get().session
  await refreshSession()
  const { session } = store.get()
  return session?.name === before?.name && session?.token !== before?.token
}

/** Whether the station shows its data: a user is logged in, or the station has no users. */
export function canView(): boolean {
  const { session } = store.get()
  return session !== null && session.login !== 'logged-out'
}

/** Tells one session from another. */
export const sessionToken = (): string => store.get().session?.token ?? ''

export const onSessionChange = store.subscribe
export const useSessionState = (): SessionState => useStore(store)
export const useSession = (): Session => useSessionState().session ?? LOGGED_OUT

/** Whether the role of the user includes `needed`. */
export const hasRole = ({ role }: Session, needed: Role): boolean => ROLES.indexOf(role) >= ROLES.indexOf(needed)
