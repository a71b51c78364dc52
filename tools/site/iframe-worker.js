/* Runs the search in a hidden frame where a page is opened from a folder, because browsers start no worker there. */
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      const frame = document.createElement("iframe");
      frame.hidden = true;
      document.body.append(frame);
      this.inner = frame.contentWindow;
      window.addEventListener("message", (event) => {
        if (event.source !== this.inner) return;
        const copy = new MessageEvent("message", { data: event.data });
        this.dispatchEvent(copy);
        if (this.onmessage) this.onmessage(copy);
      });
      const page = frame.contentDocument;
      page.open();
      page.write(`<script>
        postMessage = function (data) { parent.postMessage(data, "*"); };
        importScripts = function (...urls) {
          return urls.reduce((before, url) => before.then(() => new Promise((resolve, reject) => {
            const script = document.createElement("script");
            script.src = url; script.onload = resolve; script.onerror = reject;
            document.body.append(script);
          })), Promise.resolve());
        };
      <\/script><script src="${url}"><\/script>`);
      page.close();
      this.loaded = new Promise((resolve) => frame.addEventListener("load", resolve));
    }
    postMessage(data) {
      const send = () => this.inner.dispatchEvent(new MessageEvent("message", { data, source: window }));
      if (this.inner.document.readyState === "complete") send();
      else this.loaded.then(send);
    }
    terminate() {}
  };
}
