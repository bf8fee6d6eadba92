/**
 * Shapes of what travels between the page's modules and the server. Nothing runs here.
 *
 * @typedef {Record<string, any>} Model  the table of a model file, as JSON
 * @typedef {[number, number]} Range
 * @typedef {[number, number, number, number]} Box  left, right, bottom, top, in units of the data
 *
 * @typedef {object} Along  the parameter of the bifurcation diagram
 * @property {string} parameter
 * @property {Range} range  what is shown
 * @property {Range | null} window  what the map is confined to; null: its domain
 * @property {Range | null} view  vertical range shown; null: what the attractors need
 * @property {Range} full  the range to which a double click returns
 * @property {number} max_period  of the orbits followed
 *
 * @typedef {object} MapTold  which map a model has, as the server says
 * @property {"line" | "space" | "none" | "unknown"} kind
 * @property {string} why  there is none, in a sentence
 * @property {string[]} coordinates  of a point
 * @property {Range | null} domain
 *
 * @typedef {object} State  everything that the page shows; kept in the address
 * @property {Model} model
 * @property {number} d  where the motion of two blocks starts: a global stick
 * @property {number[]} x  displacements where any other motion starts; blocks not named are at 0
 * @property {number[]} v  and their velocities
 * @property {number} t_end
 * @property {number} power  of the second map, f^p
 * @property {number} max_period  of the orbits listed
 * @property {Along} diagram
 * @property {Record<string, any> | null} section  settings of a return map; null: the library's
 * @property {MapTold | null} map  of a model without global stick; null: not yet told
 * @property {Record<string, Range>} sliders  of a structure: what has one, and its ends
 * @property {Record<string, Box | null>} windows  zoomed views, by panel
 * @property {string[]} large  views presented, by panel; none: all are shown
 *
 * @typedef {object} Parameter  a control, described by the server
 * @property {string} name
 * @property {string} symbol
 * @property {string} meaning
 * @property {any} default
 * @property {number} min  ends of the slider; typed values may lie beyond, the server judges them
 * @property {number} max
 * @property {number} step  of the arrow keys
 * @property {"linear" | "log"} [scale]
 * @property {boolean} [per_block]  a list, with an entry for each block
 * @property {number[]} [values]  a choice in place of a range
 *
 * @typedef {object} Limits  what `shipped/limits.json` says
 * @property {{kind: string, title: string, parameters: Parameter[],
 *   forcing: Parameter[],
 *   blocks?: {min: number, max: number}, default: Model}[]} models
 * @property {{law: string, title: string, parameters: Parameter[], default: any}[]} laws
 * @property {Record<string, Record<string, {min: number, max: number, default: number}>>} requests
 * @property {Record<string, string[]>} exports
 *
 * @typedef {{name: string, title: string, state: Partial<State>}} Preset
 *
 * @typedef {Float64Array | Float32Array | Uint8Array | Int32Array} Numbers
 *
 * @typedef {object} Part  one part of an answer
 * @property {number} id
 * @property {number} part
 * @property {string} view
 * @property {boolean} last
 * @property {number} progress
 * @property {Record<string, any>} data  `part_name` and what the part holds
 * @property {Record<string, Numbers>} arrays
 * @property {{message: string, field?: string | null}} [error]
 * @property {boolean} [cancelled]
 *
 * @typedef {{view: string, request: Record<string, any>}} Question
 *
 * @typedef {object} Orbit
 * @property {number} period
 * @property {number[]} points
 * @property {number | null} multiplier
 * @property {boolean} stable
 * @property {string} kind  stable, unstable, infinitely unstable
 * @property {string[]} [itinerary]
 */
export {};
