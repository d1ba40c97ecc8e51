// The live view in Jupyter and its like, by anywidget: the page of the view in a frame of its own, and messages to and fro.
// `scene` is what Python says; `moved` is what the user has moved.

function render({ model, el }) {
  const frame = document.createElement("iframe");
  frame.title = "The live view of a scene";
  frame.style.border = "0";
  [frame.width, frame.height] = model.get("size");
  const show = () => (frame.srcdoc = model.get("html"));
  const tell = () => frame.contentWindow?.postMessage({ povgen: model.get("scene") }, "*");
  const told = ({ source, data }) => {
    if (source !== frame.contentWindow || !data?.povgen) return;
    model.set("moved", data.povgen);
    model.save_changes();
  };
  frame.addEventListener("load", tell);
  window.addEventListener("message", told);
  model.on("change:html", show);
  model.on("change:scene", tell);
  show();
  el.append(frame);
  return () => {
    window.removeEventListener("message", told);
    model.off("change:html", show);
    model.off("change:scene", tell);
  };
}

export default { render };
