// Requests to the API. Paths, parameters, bodies and answers are checked against the generated description.

import { withLocalTimes } from '../lib/format.ts'
import { t } from '../texts/texts.ts'
import type { paths } from './schema.d.ts'

type Method = 'get' | 'post' | 'delete'

/** The paths that have a method. */
type PathOf<M extends Method> = {
  [P in keyof paths]: paths[P] extends Record<M, { responses: unknown }> ? P : never
}[keyof paths]

type JsonOf<T> = T extends { content: { 'application/json': infer Json } } ? Json : undefined

/** The body of a successful answer; `undefined` if it has none. */
type AnswerOf<Operation> = Operation extends { responses: { 200: infer Answer } } ? JsonOf<Answer> : undefined

type ParametersOf<Operation> = Operation extends { parameters: infer All }
  ? Pick<All, keyof All & ('path' | 'query')>
  : never

type BodyOf<Operation> = Operation extends { requestBody: infer Body } ? { body: JsonOf<Body> } : { body?: never }

/** A request without an answer ends after this time. chosen: longer than any usual request over a slow line takes. */
const LIMIT_MS = 10_000

interface Options {
  signal?: AbortSignal | undefined
  /** Another limit than {@link LIMIT_MS}, for what takes long at the station. */
  limitMs?: number
}

/** The station refused a request, or did not answer. The message is the station's own sentence. */
export class RequestError extends Error {
  constructor(
    message: string,
    /** The HTTP status; 0 if there was no answer. */
    readonly status = 0,
    readonly body: unknown = null,
  ) {
    super(message)
  }
}

/** What requests need of the session; session.ts sets it. */
export const csrf = {
  /** Proves that a request that changes something comes from this page. */
  token: '',
  /** Called when the station answers that no user is logged in. */
  onSessionEnd: (): void => {},
  /** Fetches the session again; whether the same user has a new token, from another window. */
  refresh: (): Promise<boolean> => Promise.resolve(false),
}

/** What the page shows while an action waits for its answer; components/pending.tsx sets it. */
export const actions = {
  /** Called when an action is sent; the returned function is called when it is answered. */
  begin: (): (() => void) => () => {},
}

export function get<P extends PathOf<'get'>>(
  path: P,
  input: ParametersOf<paths[P]['get']> & Options,
): Promise<AnswerOf<paths[P]['get']>> {
  return send(addressOf(path, input), {}, input)
}

export function post<P extends PathOf<'post'>>(
  path: P,
  input: ParametersOf<paths[P]['post']> & BodyOf<paths[P]['post']> & Options,
): Promise<AnswerOf<paths[P]['post']>> {
  return change('POST', addressOf(path, input), input.body ?? null, input)
}

export function remove<P extends PathOf<'delete'>>(
  path: P,
  input: ParametersOf<paths[P]['delete']>,
): Promise<AnswerOf<paths[P]['delete']>> {
  return change('DELETE', addressOf(path, input), null, {})
}

/** The limit of requests to an archive: it waits for a connection to the database, for the statement, and for the answer of a station. */
const ARCHIVE_MS = 45_000

/** An answer of another API than the station's. */
export const getFrom = <T>(address: string, signal: AbortSignal): Promise<T> =>
  send(address, {}, { signal, limitMs: ARCHIVE_MS })

/** A change through another API than the station's. */
export const postTo = (address: string, body: unknown): Promise<unknown> =>
  change('POST', address, body, { limitMs: ARCHIVE_MS })

type Scalar = string | number
type Values = Record<string, Scalar | readonly Scalar[] | null | undefined>

/** The address of a path with its parameters. A list is repeated: `series=a&series=b`. */
export function addressOf(path: keyof paths, { path: inPath, query }: { path?: Values; query?: Values }): string {
  const filled = path.replace(/\{(\w+)\}/g, (_, name: string) => encodeURIComponent(String(inPath?.[name])))
  const text = new URLSearchParams()
  for (const [name, value] of Object.entries(query ?? {})) {
    for (const one of [value ?? []].flat()) text.append(name, String(one))
  }
  const search = text.toString()
  return search ? `${filled}?${search}` : filled
}

async function change<T>(method: string, address: string, body: unknown, options: Options): Promise<T> {
  const once = (): Promise<T> => {
    const headers = { 'content-type': 'application/json', 'x-csrf-token': csrf.token }
    return send(address, { method, headers, body: JSON.stringify(body) }, options)
  }
  return once()
    .catch(async (error: unknown) => {
      if (error instanceof RequestError && error.status === 403 && (await csrf.refresh())) return once()
      throw error
    })
    .finally(actions.begin())
}

const LOGIN: PathOf<'post'> = '/api/login'

async function send<T>(address: string, request: RequestInit, { signal, limitMs = LIMIT_MS }: Options): Promise<T> {
  const limit = AbortSignal.timeout(limitMs)
  const failed = (error: unknown, otherwise: RequestError): unknown => {
    if (signal?.aborted) return error
    return limit.aborted ? new RequestError(t.app.slow(limitMs / 1000)) : otherwise
  }
  const ends = signal ? AbortSignal.any([signal, limit]) : limit
  const answer = await fetch(address, { ...request, signal: ends }).catch((error: unknown) => {
    throw failed(error, new RequestError(t.app.noAnswer))
  })
  const body: unknown = await answer.json().catch((error: unknown) => {
    if (ends.aborted) throw failed(error, new RequestError(t.app.noAnswer))
    return null
  })
  if (answer.ok) return body as T
  if (answer.status === 401 && address !== LOGIN) csrf.onSessionEnd()
  const problem = (body as { detail?: string } | null)?.detail
  const text = typeof problem === 'string' ? withLocalTimes(problem) : t.app.answer(answer.status)
  throw new RequestError(text, answer.status, body)
}
