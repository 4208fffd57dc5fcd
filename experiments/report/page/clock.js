"use strict";
// One clock for everything on the page; it plays the videos and keeps them in step.

const FRAME_RATE = 30; // of the videos
const MAX_DRIFT = 0.12; // s; a video that is off by more is set to the clock

// Between two actions, show the first frame of the later one; times are rounded.
function nextFrame(time) {
  return (Math.floor(time * FRAME_RATE + 0.02) + 1.5) / FRAME_RATE;
}

class Clock {
  constructor(listener) {
    Object.assign(this, { listener, time: 0, duration: 0, rate: 1, playing: false, videos: [] });
  }

  load(duration, videos) {
    this.pause();
    Object.assign(this, { duration, videos });
    this.seek(this.time);
  }

  play() {
    if (this.playing || !this.duration) return;
    if (this.time >= this.duration - 1e-3) this.seek(0);
    this.playing = true;
    requestAnimationFrame((now) => this.tick(now, now));
    this.listener();
  }

  pause() {
    this.playing = false;
    for (const video of this.videos) video.pause();
    this.listener();
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  seek(time) {
    this.time = Math.max(0, Math.min(time, this.duration));
    for (const video of this.videos) video.currentTime = nextFrame(this.time);
    this.listener();
  }

  // `last`: when the frame before was shown, ms.
  tick(now, last) {
    if (!this.playing) return;
    // Wait for videos that are still loading.
    const waiting = this.videos.some((video) => video.readyState < 2 && !video.error);
    if (!waiting) this.time = Math.min(this.time + ((now - last) / 1000) * this.rate, this.duration);
    for (const video of this.videos) this.keep(video);
    if (this.time < this.duration) {
      this.listener();
      requestAnimationFrame((next) => this.tick(next, now));
    } else {
      this.pause();
      this.seek(this.duration); // the videos are a few frames behind, and the last one shows the result
    }
  }

  // Keep a video in step; at its end it shows its last frame.
  keep(video) {
    if (video.currentTime >= video.duration) return;
    video.playbackRate = this.rate;
    // A pause may reject an earlier play(), which is no error.
    if (video.paused) video.play().catch(() => {});
    const drift = Math.abs(video.currentTime - this.time);
    if (!video.seeking && drift > MAX_DRIFT * Math.max(1, this.rate)) video.currentTime = this.time;
  }
}
