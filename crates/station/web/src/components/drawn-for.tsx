// A part of a page that is drawn again only when something that it shows has changed.

import { Component, type JSX } from 'preact'

interface Props {
  /** All that the part shows. Functions that it calls are not among it. */
  what: readonly unknown[]
  draw: () => JSX.Element
}

export class DrawnFor extends Component<Props> {
  override shouldComponentUpdate({ what }: Props): boolean {
    return what.some((one, index) => one !== this.props.what[index])
  }

  override render(): JSX.Element {
    return this.props.draw()
  }
}
