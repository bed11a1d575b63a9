// What stands on an offer beside its prices, and who offers; Rust says which fields there are.

import { letterForm } from '../pkg/truefeed_whole.js'
import { make } from '../dom.js'
import { field } from '../field.js'
import { say } from '../texts_later.js'

/** @import { Parameter, State, Value } from "../types.js" */

/** @param {HTMLElement} root @param {{setLetter(key: string, value: Value): void, setCompany(key: string, value: Value): void}} actions */
export function mount(root, actions) {
  /** @type {{offer: Parameter[], company: Parameter[]}} */
  const form = JSON.parse(letterForm())
  const isText = (/** @type {Parameter} */ { kind }) => kind !== 'picture'
  const offer = form.offer.map((parameter) => field('offer', parameter, actions.setLetter))
  const company = form.company.filter(isText).map((parameter) => field('company', parameter, actions.setCompany))
  const logo = form.company.find((parameter) => !isText(parameter))
  const today = make('button', { type: 'button' }, say.letter.today)
  // The clock is the user's, and asked only here.
  today.addEventListener('click', () => actions.setLetter('date', new Date().toLocaleDateString('sv')))
  const picture = make('img', { alt: '', className: 'logo', hidden: true })
  const input = make('input', { type: 'file', accept: 'image/png,image/jpeg', id: 'company-logo' })
  const none = make('button', { type: 'button', hidden: true }, say.letter.noLogo)
  input.addEventListener('change', async () => {
    const [file] = input.files ?? []
    if (file) actions.setCompany('logo', await dataAddress(file))
    input.value = ''
  })
  none.addEventListener('click', () => actions.setCompany('logo', null))
  const ofLogo = make('div', { className: 'field' }, make('label', { htmlFor: input.id, title: logo?.doc ?? '' }, logo?.label ?? ''), input, picture, none)
  root.append(
    make('details', {}, make('summary', {}, say.letter.offer), ...offer.map(({ element }) => element), make('p', { className: 'choices' }, today)),
    make('details', {}, make('summary', {}, say.letter.company), ...company.map(({ element }) => element), ofLogo),
  )
  return {
    /** @param {State} state */
    update({ letter, company: profile }) {
      for (const { parameter, show } of offer) show(letter[parameter.key] ?? parameter.neutral, '')
      for (const { parameter, show } of company) show(profile[parameter.key] ?? parameter.neutral, '')
      const address = String(profile.logo ?? '')
      picture.hidden = none.hidden = !address
      if (picture.getAttribute('src') !== address) picture.src = address
    },
  }
}

/** @param {Blob} file @returns {Promise<string>} */
const dataAddress = (file) =>
  new Promise((resolve, reject) => {
    const reader = new FileReader()
    reader.onload = () => resolve(String(reader.result))
    reader.onerror = () => reject(reader.error)
    reader.readAsDataURL(file)
  })
