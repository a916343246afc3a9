// Each slider compares two of the pictures in the tiles before it. Without this script the tiles are still there.
"use strict";
for (const slider of document.querySelectorAll(".slider")) {
  let before = slider.previousElementSibling;
  while (before && !before.classList.contains("pictures")) before = before.previousElementSibling;
  if (!before) continue;
  const pictures = [...before.querySelectorAll("img.whole")];
  if (pictures.length < 2) continue;
  const [left, right] = [slider.querySelector(".left"), slider.querySelector(".right")];
  const [over, under] = [slider.querySelector(".over"), slider.querySelector(".under")];
  const range = slider.querySelector("input");
  for (const select of [left, right]) {
    pictures.forEach((picture, i) => select.add(new Option(picture.alt, i)));
  }
  const show = () => {
    over.src = pictures[left.value].src;
    under.src = pictures[right.value].src;
    over.style.clipPath = `inset(0 ${100 - range.value}% 0 0)`;
  };
  left.value = 1;
  right.value = 0;
  for (const control of [left, right, range]) control.addEventListener("input", show);
  show();
  slider.hidden = false;
}
