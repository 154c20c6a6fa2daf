"use strict";
{
  const setting = document.getElementById("setting");
  const slider = document.getElementById("cut");
  const over = document.getElementById("over");

  const show = () => {
    const chosen = setting.selectedOptions[0].dataset;
    for (const kind of ["picture", "difference"]) {
      for (const image of document.querySelectorAll(`img[data-${kind}]`)) {
        image.hidden = image.dataset[kind] !== chosen[kind];
      }
    }
    document.getElementById("chosen").textContent = chosen.facts;
  };
  const cut = () => over.style.setProperty("--cut", `${slider.value}%`);
  const drag = (event) => {
    if (event.buttons !== 1) return;
    const { left, width } = over.getBoundingClientRect();
    slider.value = (100 * (event.clientX - left)) / width;
    cut();
  };

  setting.addEventListener("change", show);
  slider.addEventListener("input", cut);
  over.addEventListener("pointerdown", drag);
  over.addEventListener("pointermove", drag);
  // Browsers keep what was chosen when a page is loaded again.
  show();
  cut();
}
