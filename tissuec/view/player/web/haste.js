// How simply pictures are drawn while something moves, so that they follow one another quickly.

const SLOW = 40;  // milliseconds from one picture to the next that are too many
const QUICK = 20;  // milliseconds that leave room for better pictures
const LASTING = 120;  // quick pictures in a row after which better ones are tried
const TRIES = 2;  // how often; if pictures themselves are slow, each try is visible
const STILL = 200;  // milliseconds without a new picture, after which nothing moves
// Samples of each pixel, size of pictures, and the most faces and springs.
const FORMS = [
  { samples: 4, scale: 1, faces: Infinity, springs: Infinity },
  { samples: 0, scale: 1, faces: 16000, springs: 24000 },
  { samples: 0, scale: 0.75, faces: 6000, springs: 12000 },
  { samples: 0, scale: 0.5, faces: 0, springs: 6000 },
];

class Haste {
  constructor() { this.reset(); }

  // Begin with full pictures again, for something else is drawn.
  reset() { Object.assign(this, { level: 0, slow: 0, quick: 0, tries: 0 }); }

  // Take how long a picture took: after three slow ones in a row they become simpler, after
  // many quick ones better again, for something else may have been slow.
  take(pause) {
    this.slow = pause > SLOW ? this.slow + 1 : 0;
    this.quick = pause < QUICK ? this.quick + 1 : 0;
    if (this.quick === LASTING && this.level > 0 && this.tries < TRIES) {
      Object.assign(this, { level: this.level - 1, quick: 0, tries: this.tries + 1 });
    }
    if (this.slow < 3) return;
    this.slow = 0;
    this.level = Math.min(FORMS.length - 1, this.level + (pause > 3 * SLOW ? 2 : 1));
  }

  // Return how pictures are drawn while something moves.
  get form() { return FORMS[this.level]; }
}
