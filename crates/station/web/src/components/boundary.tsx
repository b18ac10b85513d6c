// A fault of a page becomes words: without them the browser would show nothing.

import { Component, type ComponentChildren } from 'preact'
import { t } from '../texts/texts.ts'
import { errorText } from './hooks.ts'

interface State {
  problem: string | null
}

interface Props {
  /** Another page is tried again. */
  page?: string
  children: ComponentChildren
}

export class Boundary extends Component<Props, State> {
  override state: State = { problem: null }

  static override getDerivedStateFromError(error: unknown): State {
    return { problem: errorText(error) }
  }

  override componentDidCatch(error: unknown): void {
    console.error(error)
  }

  override componentDidUpdate({ page }: Props): void {
    if (page !== this.props.page && this.state.problem !== null) this.setState({ problem: null })
  }

  override render(): ComponentChildren {
    const { problem } = this.state
    if (problem === null) return this.props.children
    return (
      <div role="alert">
        <p class="error">{t.app.broken(problem)}</p>
        <button type="button" onClick={() => location.reload()}>
          {t.app.reload}
        </button>
      </div>
    )
  }
}
