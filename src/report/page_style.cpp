#include "report/page_style.hpp"

namespace drench {

std::string_view style_sheet() {
  return R"(
:root{color-scheme:light dark;--page:#fff;--ink:#1b2430;--soft:#5b6675;--line:#d9dfe6;--card:#f5f7f9;--bad:#b3261e;
--badbg:#fdecea;--warn:#8a5a00;--warnbg:#fff5e0;--good:#00664b;
--c0:#0072b2;--c1:#c65300;--c2:#00805d;--c3:#b0588f;--c4:#a86f00;--c5:#2b8fc4;--c6:#7a6a00;--c7:#737b85;
--a0:#0072b2;--a1:#d55e00;--a2:#009e73;--a3:#cc79a7;--a4:#e69f00;--a5:#56b4e9;--a6:#f0e442;--a7:#b4bac2}
@media screen and (prefers-color-scheme:dark){:root{--page:#12171d;--ink:#e4e9ef;--soft:#9aa6b4;--line:#333d48;
--card:#1b222a;--bad:#ff8a80;--badbg:#3a1a18;--warn:#ffc560;--warnbg:#33270f;--good:#4fd1a5;
--c0:#56b4e9;--c1:#ff8a4c;--c2:#2fc79a;--c3:#e09cc3;--c4:#f0b53c;--c5:#8fd0f5;--c6:#f0e442;--c7:#a5adb7;
--a0:#2d86bd;--a1:#c9601c;--a2:#119a73;--a3:#b56d96;--a4:#c98d14;--a5:#5fb0dd;--a6:#cfc53a;--a7:#666f79}}
*{box-sizing:border-box}
body{margin:0 auto;padding:1.2rem 1rem 3rem;max-width:68rem;background:var(--page);color:var(--ink);
font:16px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"Noto Sans","DejaVu Sans",sans-serif}
h1{font-size:1.7rem;line-height:1.2;margin:.2rem 0 .4rem;overflow-wrap:anywhere}
h2{font-size:1.2rem;margin:2.4rem 0 .7rem;padding-top:.7rem;border-top:1px solid var(--line)}
h3{font-size:1rem;margin:1.4rem 0 .4rem}
p{margin:.5rem 0}.note{color:var(--soft);font-size:.86rem;max-width:46rem}
nav{font-size:.88rem;margin:.6rem 0 1rem;line-height:2}nav a{margin-right:.9rem;white-space:nowrap}a{color:var(--c0)}
.badge{display:inline-block;padding:.1rem .7rem;border-radius:1rem;font-weight:600;font-size:.9rem;
border:1.5px solid currentColor}
.done{color:var(--good)}.failed,.stopped{color:var(--bad)}.interrupted,.unfinished{color:var(--warn)}
.box{border-left:4px solid;border-radius:4px;padding:.7rem 1rem;margin:1rem 0;overflow-wrap:anywhere}
.box.bad{border-color:var(--bad);background:var(--badbg)}.box.warn{border-color:var(--warn);background:var(--warnbg)}
.box h2{border:0;margin:0 0 .3rem;padding:0;font-size:1.1rem}.box dl{margin:.4rem 0 0;display:grid;
grid-template-columns:max-content 1fr;gap:.15rem .9rem}.box dt{font-weight:600}.box dd{margin:0}
.cards{display:grid;grid-template-columns:repeat(auto-fill,minmax(10.5rem,1fr));gap:.6rem;margin:1rem 0;padding:0}
.cards div{background:var(--card);border-radius:8px;padding:.5rem .75rem}.cards dt{color:var(--soft);font-size:.8rem}
.cards dd{margin:0;font-weight:600;font-size:1.06rem;overflow-wrap:anywhere}
.charts{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,26rem),1fr));gap:1rem 1.4rem;margin:.6rem 0}
figure{margin:0;break-inside:avoid}figcaption{font-weight:600;font-size:.95rem;margin-bottom:.2rem}
svg.chart{display:block;width:100%;height:auto;max-width:40rem}svg text{font-size:13px;fill:var(--soft);
font-family:inherit}
svg .m{text-anchor:middle}svg .e{text-anchor:end}
.grid{stroke:var(--line)}.axis,.tick{stroke:var(--soft)}
.l{fill:none;stroke-width:1.8;stroke-linejoin:round}.dashed{stroke-dasharray:6 3.5}.level{stroke-dasharray:2 3;
stroke-width:1.4}
.cursor{stroke:var(--soft);stroke-dasharray:2 2}
.scroll{overflow-x:auto;margin:.7rem 0}table{border-collapse:collapse;font-size:.9rem;min-width:20rem}
th,td{padding:.25rem .8rem .25rem 0;text-align:left;border-bottom:1px solid var(--line);vertical-align:top}
tbody th{font-weight:400}thead th{color:var(--soft);font-weight:600;vertical-align:bottom}
.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
.n:is(thead *){white-space:normal}tbody th{min-width:7.5rem}
.swatch{display:inline-block;width:.8em;height:.8em;border-radius:2px;margin-right:.45em;vertical-align:-.05em}
.pictures{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(46%,17rem),1fr));gap:.8rem}
.pictures.four{grid-template-columns:repeat(auto-fill,minmax(min(46%,13.5rem),1fr))}
.pictures figcaption{font-weight:400;font-size:.85rem;color:var(--soft);margin-top:.2rem}
.pictures img{display:block;width:100%;height:auto;border-radius:6px;background:#eef1f5}
.bar{height:.8rem;border-radius:4px;max-width:17rem;
background:linear-gradient(90deg,#f2ebd9,#948c8f 42%,#292b40 83%,#212333)}
pre{background:var(--card);border-radius:8px;padding:.8rem 1rem;overflow-x:auto;font-size:.8rem;line-height:1.45}
#tip{position:absolute;pointer-events:none;background:var(--ink);color:var(--page);font-size:.8rem;line-height:1.35;
padding:.3rem .55rem;border-radius:5px;white-space:pre;font-variant-numeric:tabular-nums;display:none;z-index:2}
.key{display:inline-block;width:2.2em;border-top:2px solid var(--ink);vertical-align:.3em;margin:0 .3em}
.key.b{border-top-style:dashed}
.s0{stroke:var(--c0)}.s1{stroke:var(--c1)}.s2{stroke:var(--c2)}.s3{stroke:var(--c3)}.s4{stroke:var(--c4)}
.s5{stroke:var(--c5)}.s6{stroke:var(--c6)}.s7{stroke:var(--c7)}
.f0{fill:var(--a0);background:var(--a0)}.f1{fill:var(--a1);background:var(--a1)}.f2{fill:var(--a2);background:var(--a2)}
.f3{fill:var(--a3);background:var(--a3)}.f4{fill:var(--a4);background:var(--a4)}.f5{fill:var(--a5);background:var(--a5)}
.f6{fill:var(--a6);background:var(--a6)}.f7{fill:var(--a7);background:var(--a7)}
svg .t0{fill:var(--c0)}svg .t1{fill:var(--c1)}svg .t2{fill:var(--c2)}svg .t3{fill:var(--c3)}svg .t4{fill:var(--c4)}
svg .t5{fill:var(--c5)}svg .t6{fill:var(--c6)}svg .t7{fill:var(--c7)}
@media print{.scroll{overflow:visible}table{font-size:8pt}th,td{padding-right:.45rem}tbody th{min-width:4rem}
body{max-width:none;padding:0;font-size:10pt}nav,#tip{display:none!important}h2{break-after:avoid}
.charts{grid-template-columns:1fr 1fr}.pictures{grid-template-columns:repeat(3,1fr)}
tr,.cards div,.box{break-inside:avoid}*{print-color-adjust:exact;-webkit-print-color-adjust:exact}
details>*{display:block}pre{white-space:pre-wrap;overflow-wrap:anywhere}}
@media (max-width:32rem){body{padding:.8rem .8rem 2rem}svg text{font-size:13.5px}
.pictures{grid-template-columns:1fr 1fr}}
)";
}

std::string_view chart_script() {
  return R"(
(function(){
const tip=document.createElement('div');tip.id='tip';document.body.append(tip);
const short=v=>Number(v.toPrecision(4)).toString();
const list=s=>s.split(' ').map(Number);
document.querySelectorAll('svg.chart').forEach(svg=>{
  const lines=[...svg.querySelectorAll('path.l')];
  if(!lines.length)return;
  const [left,top,width,height]=list(svg.dataset.box),[x0,x1]=list(svg.dataset.x),[y0,y1]=list(svg.dataset.y),
log=svg.dataset.log==='1';
  let curves,cursor;
  const value=y=>{const p=1-(y-top)/height;return log?y0*Math.pow(y1/y0,p):y0+p*(y1-y0);};
  const hide=()=>{tip.style.display='none';if(cursor)cursor.style.display='none';};
  svg.addEventListener('pointermove',e=>{
    const box=svg.getBoundingClientRect(),x=(e.clientX-box.left)*svg.viewBox.baseVal.width/box.width;
    if(x<left||x>left+width)return hide();
    curves=curves||lines.map(l=>({name:l.dataset.name,points:l.getAttribute('d').slice(1).split('L').map(list)}));
    if(!cursor){cursor=document.createElementNS('http://www.w3.org/2000/svg','line');
cursor.setAttribute('class','cursor');cursor.setAttribute('y1',top);cursor.setAttribute('y2',top+height);
svg.append(cursor);}
    cursor.setAttribute('x1',x);cursor.setAttribute('x2',x);cursor.style.display='';
    tip.textContent='t = '+short(x0+(x-left)/width*(x1-x0))+' s'+curves.map(c=>{
      let best=c.points[0];for(const p of c.points)if(Math.abs(p[0]-x)<Math.abs(best[0]-x))best=p;
      return '\n'+(c.name?c.name+'  ':'')+'≈ '+short(value(best[1]));}).join('');
    tip.style.display='block';
    tip.style.left=Math.max(4,Math.min(e.pageX+14,document.documentElement.clientWidth-tip.offsetWidth-4))+'px';
tip.style.top=(e.pageY+14)+'px';
  });
  svg.addEventListener('pointerleave',hide);
});
const d=document.querySelectorAll('details');
addEventListener('beforeprint',()=>d.forEach(x=>{x.dataset.was=x.open?1:0;x.open=true;}));
addEventListener('afterprint',()=>d.forEach(x=>{x.open=x.dataset.was==='1';}));
})();
)";
}

}  // namespace drench
