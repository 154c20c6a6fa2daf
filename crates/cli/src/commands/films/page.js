"use strict";
(() => {
  const pictures = [...document.querySelectorAll("#frames img")];
  const canvas = document.querySelector("canvas");
  const [slider, button, output] = ["input", "button", "output"].map((name) => document.querySelector(name));
  const brush = canvas.getContext("2d");
  const count = pictures.length;
  const closed = canvas.dataset.closed === "true";
  const pause = 1000 / Number(canvas.dataset.fps);
  // Frames, with a fraction while the pointer is between two.
  let place = 0;
  let asked = 0;
  let drawn = 0;
  let timer = null;

  const within = (frame) => (closed ? ((frame % count) + count) % count : Math.min(Math.max(frame, 0), count - 1));

  const draw = async (picture) => {
    const turn = ++asked;
    await picture.decode().catch(() => {});
    // A later frame that was ready sooner stays.
    if (turn > drawn) {
      drawn = turn;
      brush.drawImage(picture, 0, 0, canvas.width, canvas.height);
    }
  };

  const go = (frame) => {
    place = within(frame);
    const shown = Math.floor(place);
    slider.value = shown;
    output.value = `frame ${shown + 1} of ${count}`;
    slider.setAttribute("aria-valuetext", output.value);
    return draw(pictures[shown]);
  };

  const stop = () => {
    clearInterval(timer);
    timer = null;
    button.textContent = "Play";
  };

  const play = () => {
    if (!closed && place >= count - 1) {
      go(0);
    }
    button.textContent = "Pause";
    timer = setInterval(() => {
      if (!closed && place >= count - 1) {
        stop();
      } else {
        go(Math.floor(place) + 1);
      }
    }, pause);
  };

  const toggle = () => (timer === null ? play() : stop());

  button.addEventListener("click", toggle);
  slider.addEventListener("input", () => {
    stop();
    go(Number(slider.value));
  });

  let from = null;
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) {
      return;
    }
    stop();
    canvas.setPointerCapture(event.pointerId);
    from = { x: event.clientX, place };
  });
  canvas.addEventListener("pointermove", (event) => {
    if (from === null) {
      return;
    }
    // The whole width is a whole turn, in which what is in front follows the pointer; along a path it is all frames.
    const way = ((event.clientX - from.x) / canvas.clientWidth) * (closed ? -count : count - 1);
    go(from.place + way);
  });
  for (const end of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(end, () => {
      from = null;
    });
  }

  const jump = Math.max(1, Math.round(count / 10));
  const keys = {
    ArrowLeft: () => go(Math.floor(place) - 1),
    ArrowRight: () => go(Math.floor(place) + 1),
    PageDown: () => go(Math.floor(place) - jump),
    PageUp: () => go(Math.floor(place) + jump),
    Home: () => go(0),
    End: () => go(count - 1),
  };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) {
      return;
    }
    if (event.key === " " && event.target !== button) {
      event.preventDefault();
      toggle();
    } else if (Object.hasOwn(keys, event.key)) {
      event.preventDefault();
      stop();
      keys[event.key]();
    }
  });

  go(0);
})();
