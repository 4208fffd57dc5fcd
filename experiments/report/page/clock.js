"use strict";
// One clock that everything on the page follows; films are played by it, and kept in step with one another.

const FRAME_RATE = 30; // of the films
const FILM_DRIFT = 0.12; // s by which a film may be off before it is set right

// A film's picture at the border of two actions is to be the later one's: the first after that time, which is rounded.
function nextFrame(time) {
  return (Math.floor(time * FRAME_RATE + 0.02) + 1.5) / FRAME_RATE;
}

class Clock {
  constructor(listener) {
    this.listener = listener;
    this.time = 0;
    this.duration = 0;
    this.rate = 1;
    this.playing = false;
    this.films = [];
    this.last = null;
  }

  load(duration, films) {
    this.pause();
    this.duration = duration;
    this.films = films;
    this.seek(Math.min(this.time, duration));
  }

  play() {
    if (this.playing || !this.duration) return;
    if (this.time >= this.duration - 1e-3) this.seek(0);
    this.playing = true;
    this.last = null;
    for (const film of this.films) this.roll(film);
    requestAnimationFrame((now) => this.tick(now));
    this.listener();
  }

  pause() {
    this.playing = false;
    for (const film of this.films) film.pause();
    this.listener();
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  seek(time) {
    this.time = Math.max(0, Math.min(time, this.duration));
    for (const film of this.films) {
      film.currentTime = nextFrame(this.time);
      if (this.playing) this.roll(film);
    }
    this.listener();
  }

  setRate(rate) {
    this.rate = rate;
    for (const film of this.films) film.playbackRate = rate;
  }

  roll(film) {
    film.playbackRate = this.rate;
    // A film that is over stays at its last picture. A play() that a pause overtakes is no failure.
    if (!(film.currentTime >= film.duration)) film.play().catch(() => {});
  }

  tick(now) {
    if (!this.playing) return;
    const passed = this.last === null ? 0 : ((now - this.last) / 1000) * this.rate;
    this.last = now;
    // The clock waits for films that are still loading, rather than running ahead of them.
    const waiting = this.films.some((film) => film.readyState < 2 && !film.error);
    if (!waiting) this.time = Math.min(this.time + passed, this.duration);
    for (const film of this.films) {
      const over = film.currentTime >= film.duration;
      if (!over && !film.seeking && Math.abs(film.currentTime - this.time) > FILM_DRIFT * Math.max(1, this.rate)) {
        film.currentTime = this.time;
      }
    }
    if (this.time >= this.duration) {
      this.pause();
      this.seek(this.duration); // the films are behind by a few pictures, and the last one shows what has been done
    } else {
      this.listener();
      requestAnimationFrame((next) => this.tick(next));
    }
  }
}
